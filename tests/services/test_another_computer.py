"""Two computers that trust each other by certificates; both are this one here."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
import trustme

import tsd_casadi as tsd
from tsd_casadi.exceptions import CertificateRefused, InvalidValue, ServiceNotReady
from tsd_casadi.wire.zenoh_file import ZenohFile, read_zenoh_file
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.remote.service_health import services_at
from tsd_server.service_process import ServiceProcess, free_endpoint

EXAMPLE = Path(__file__).parents[2] / "examples" / "another_computer"
NOW = datetime.now(UTC)
YEAR, DAY = timedelta(days=365), timedelta(days=1)


def write(folder: Path, name: str, certificate: trustme.LeafCert) -> None:
    certificate.private_key_pem.write_to_path(folder / f"{name}.key")
    pem = b"".join(each.bytes() for each in certificate.cert_chain_pems)
    (folder / f"{name}.pem").write_bytes(pem)


@pytest.fixture(scope="module")
def authority() -> trustme.CA:
    return trustme.CA()


@pytest.fixture(scope="module")
def folder(authority: trustme.CA, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The documented files, with certificates as the documentation has them made."""
    folder = tmp_path_factory.mktemp("keys")
    for path in EXAMPLE.glob("*.json5"):
        shutil.copy(path, folder)
    authority.cert_pem.write_to_path(folder / "authority.pem")
    write(folder, "robot", authority.issue_cert("127.0.0.1"))
    write(folder, "laptop", authority.issue_cert("laptop"))
    return folder


@pytest.fixture(scope="module")
def endpoint(folder: Path, controller: tsd.Controller) -> Iterator[str]:
    endpoint = free_endpoint().replace("tcp/", "tls/")
    arguments = ["controller", "--listen", endpoint, "--zenoh-config", str(folder / "robot.json5")]
    with ServiceProcess(arguments):
        yield endpoint


@pytest.fixture
def laptop(folder: Path, tmp_path: Path) -> Callable[..., ZenohFile]:
    """A laptop's configuration, with other certificates if one is given."""

    def make(
        certificate: trustme.LeafCert | None = None, authority: trustme.CA | None = None
    ) -> ZenohFile:
        copy = tmp_path / "laptop"
        shutil.copytree(folder, copy)
        if certificate is not None:
            write(copy, "laptop", certificate)
        if authority is not None:
            authority.cert_pem.write_to_path(copy / "authority.pem")
        return read_zenoh_file(copy / "laptop.json5")

    return make


def test_with_its_certificate_the_other_computer_gets_the_same_torque(
    robot: tsd.Robot, controller: tsd.Controller, endpoint: str, laptop: Callable[..., ZenohFile]
) -> None:
    with RemoteController(robot.name, [endpoint], zenoh_file=laptop()) as remote:
        there = remote.tick(robot.home, remote.command()).tau
    np.testing.assert_array_equal(there, controller.tick(robot.home, controller.command()).tau)


def test_its_status_is_answered(endpoint: str, laptop: Callable[..., ZenohFile]) -> None:
    (state,) = services_at(endpoint, laptop())
    assert state.health is not None
    assert state.health.role == "controller"


def refused(endpoint: str, file: ZenohFile, words: str) -> None:
    with pytest.raises(CertificateRefused, match=words) as caught:
        RemoteController("hermes_lower", [endpoint], zenoh_file=file)
    assert caught.value.endpoint == endpoint
    (state,) = services_at(endpoint, file)
    assert words in state.trouble


def test_an_expired_certificate_is_named(
    authority: trustme.CA, endpoint: str, laptop: Callable[..., ZenohFile]
) -> None:
    old = authority.issue_cert("laptop", not_before=NOW - YEAR, not_after=NOW - DAY)
    refused(endpoint, laptop(old), "laptop.pem has expired")


def test_one_that_is_not_valid_yet_is_named(
    authority: trustme.CA, endpoint: str, laptop: Callable[..., ZenohFile]
) -> None:
    early = authority.issue_cert("laptop", not_before=NOW + DAY, not_after=NOW + YEAR)
    refused(endpoint, laptop(early), "laptop.pem is not valid yet")


def test_one_of_another_authority_is_named(endpoint: str, laptop: Callable[..., ZenohFile]) -> None:
    stranger = trustme.CA().issue_cert("laptop")
    refused(endpoint, laptop(stranger), "laptop.pem is from an authority")


def test_a_robot_of_another_authority_is_not_believed(
    endpoint: str, laptop: Callable[..., ZenohFile]
) -> None:
    other = trustme.CA()
    file = laptop(other.issue_cert("laptop"), other)
    refused(endpoint, file, "its certificate is from an authority that this end does not know")


def test_what_the_service_says_of_a_certificate_it_does_not_know(
    authority: trustme.CA, endpoint: str, laptop: Callable[..., ZenohFile]
) -> None:
    both = trustme.CA()
    file = laptop(both.issue_cert("laptop"), both)
    # this end trusts both authorities, the service only its own
    path = Path(file.section("transport", "link", "tls")["root_ca_certificate"])
    path.write_bytes(both.cert_pem.bytes() + authority.cert_pem.bytes())
    refused(endpoint, file, "this end's certificate is from an authority that it does not know")


def test_a_missing_file_is_named(endpoint: str, laptop: Callable[..., ZenohFile]) -> None:
    file = laptop()
    Path(file.section("transport", "link", "tls")["connect_certificate"]).unlink()
    refused(endpoint, file, "laptop.pem is missing")


def test_without_a_certificate_it_is_said_that_one_is_asked_for(
    endpoint: str, laptop: Callable[..., ZenohFile]
) -> None:
    file = laptop()
    del file.settings["transport"]["link"]["tls"]["connect_certificate"]
    refused(endpoint, file, "it asks for a certificate and this end has none")


def test_a_robot_under_another_name_is_not_believed(
    endpoint: str, laptop: Callable[..., ZenohFile]
) -> None:
    other = endpoint.replace("127.0.0.1", "localhost")
    refused(other, laptop(), "its certificate is for another host than localhost")


def test_plain_tcp_gets_no_torque(endpoint: str) -> None:
    (plain,) = services_at(endpoint.replace("tls/", "tcp/"))
    assert plain.health is None
    assert "one that asks for a certificate" in plain.trouble


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda path: path.with_name("robot.pem").unlink(), "robot.pem is missing"),
        (lambda path: path.with_name("robot.key").write_text("no key"), "cannot be used"),
        (
            lambda path: path.write_text(path.read_text().replace("listen_certificate", "// ")),
            "a service without a certificate",
        ),
        (lambda path: path.write_text('{transport: {tls: "no section"}}'), "unknown field `tls`"),
    ],
)
def test_a_service_whose_certificate_cannot_be_used_does_not_start(
    folder: Path, tmp_path: Path, spoil: Callable[[Path], object], words: str
) -> None:
    shutil.copytree(folder, tmp_path / "copy")
    path = tmp_path / "copy" / "robot.json5"
    spoil(path)
    endpoint = free_endpoint()
    if words != "unknown field `tls`":
        endpoint = endpoint.replace("tcp/", "tls/")
    database = str(tmp_path / "a.sqlite")
    with pytest.raises(ServiceNotReady, match=words):
        ServiceProcess(
            ["learner", "--database", database, "--listen", endpoint, "--zenoh-config", str(path)]
        )


def test_an_expired_certificate_of_the_service_is_named_at_its_start(
    authority: trustme.CA, folder: Path, tmp_path: Path
) -> None:
    shutil.copytree(folder, tmp_path / "copy")
    old = authority.issue_cert("127.0.0.1", not_before=NOW - YEAR, not_after=NOW - DAY)
    write(tmp_path / "copy", "robot", old)
    arguments = ["--database", str(tmp_path / "a.sqlite")]
    arguments += ["--zenoh-config", str(tmp_path / "copy" / "robot.json5")]
    endpoint = free_endpoint().replace("tcp/", "tls/")
    with pytest.raises(ServiceNotReady, match=r"robot\.pem has expired"):
        ServiceProcess(["learner", "--listen", endpoint, *arguments])


def test_nobody_listens_to_other_machines_by_accident(tmp_path: Path) -> None:
    port = free_endpoint().rpartition(":")[2]
    arguments = ["learner", "--database", str(tmp_path / "a"), "--listen", f"tcp/0.0.0.0:{port}"]
    with pytest.raises(ServiceNotReady, match="which other machines can reach"):
        ServiceProcess(arguments)
    with ServiceProcess([*arguments, "--expose"]) as service:
        (warning,) = [line for line in service.output if "WARNING" in line]
    assert "open to other machines" in warning
    assert "nothing checks who that is" in warning


def test_the_command_line_takes_the_files(
    folder: Path, endpoint: str, laptop: Callable[..., ZenohFile]
) -> None:
    options = ["--connect", endpoint, "--zenoh-config", str(folder / "laptop.json5")]
    done = subprocess.run(
        [sys.executable, "-m", "tsd_cli", "status", *options],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "controller" in done.stdout


def test_a_file_that_is_none_is_refused_before_anything_else(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match="--zenoh-config"):
        read_zenoh_file(tmp_path)
