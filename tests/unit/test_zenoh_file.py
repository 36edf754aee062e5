from __future__ import annotations

from pathlib import Path

import pytest

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.wire.session_settings import ACCESS, session_settings
from tsd_casadi.wire.zenoh_file import read_zenoh_file

JSON5 = """\
// of the robot
{
  metadata: { name: "two // inside a text" },
  mode: "router", /* in
  the middle */
  listen: { endpoints: ["tls/10.0.0.1:7447"], },
  transport: { link: { tls: {
    root_ca_certificate: "ca.pem",
    listen_certificate: "/etc/robot.pem",
    enable_mtls: true,
  } } },
}
"""


def write(folder: Path, text: str, name: str = "robot.json5") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_json5_is_read_and_paths_are_relative_to_the_file(tmp_path: Path) -> None:
    file = read_zenoh_file(write(tmp_path, JSON5))
    assert file.endpoints("listen") == ["tls/10.0.0.1:7447"]
    assert file.endpoints("connect") == []
    assert file.section("transport", "link", "tls") == {
        "root_ca_certificate": str(tmp_path / "ca.pem"),
        "listen_certificate": "/etc/robot.pem",
        "enable_mtls": True,
    }
    assert file.section("transport", "auth", "usrpwd") == {}
    assert file.section("mode") == {}
    assert file.section("metadata") == {"name": "two // inside a text"}


def test_yaml_is_read_too(tmp_path: Path) -> None:
    text = "mode: client  # at home\nconnect:\n  endpoints: [tcp/10.0.0.1:7447]\n"
    file = read_zenoh_file(write(tmp_path, text, "me.yaml"))
    assert file.endpoints("connect") == ["tcp/10.0.0.1:7447"]
    assert file.settings["mode"] == "client"


def test_the_file_goes_before_our_settings_but_not_before_named_endpoints(tmp_path: Path) -> None:
    file = read_zenoh_file(write(tmp_path, JSON5))
    settings = file.applied_to(session_settings(listen=["tls/10.0.0.1:7450"], service="learner"))
    assert settings["mode"] == "router"
    assert settings["listen"]["endpoints"] == ["tls/10.0.0.1:7450"]
    assert settings["listen"]["exit_on_failure"] is True
    assert settings["scouting"]["multicast"]["enabled"] is False
    assert settings["transport"]["link"]["tls"]["enable_mtls"] is True
    assert settings["transport"]["link"]["tx"]["lease"] == 1000


def test_what_services_refuse_stays_refused(tmp_path: Path) -> None:
    text = (
        '{"access_control": {"enabled": false, "default_permission": "deny", '
        '"rules": [{"id": "r"}], "subjects": [{"id": "s"}], "policies": []}}'
    )
    file = read_zenoh_file(write(tmp_path, text))
    access = file.applied_to(session_settings(service="controller"))["access_control"]
    assert access["enabled"] is True
    assert access["default_permission"] == "deny"
    assert access["rules"] == [{"id": "r"}, *ACCESS["rules"]]
    assert access["subjects"] == [{"id": "s"}, *ACCESS["subjects"]]
    assert access["policies"] == ACCESS["policies"]
    client = file.applied_to(session_settings())["access_control"]
    assert client["rules"] == [{"id": "r"}]


@pytest.mark.parametrize("text", ["", "[1]", "{", "mode", "\0"])
def test_what_is_no_document_is_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match="--zenoh-config"):
        read_zenoh_file(write(tmp_path, text))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match=r"none\.json5 \(No such file"):
        read_zenoh_file(tmp_path / "none.json5")


@pytest.mark.parametrize("endpoints", ['{peer: ["tcp/[::1]:1"]}', "[7447]", '["7447"]'])
def test_endpoints_that_are_none_are_refused(endpoints: str, tmp_path: Path) -> None:
    file = read_zenoh_file(write(tmp_path, f"{{listen: {{endpoints: {endpoints}}}}}"))
    with pytest.raises(InvalidValue, match="endpoint"):
        file.endpoints("listen")
