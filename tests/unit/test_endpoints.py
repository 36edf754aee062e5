from __future__ import annotations

import json
import os

import pytest
import zenoh

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.wire.endpoints import (
    CONTROLLER,
    LEARNER,
    RUNTIME,
    check_endpoint,
    configure_runtime,
    session_settings,
)


def test_default_endpoints_are_on_this_machine_and_differ() -> None:
    assert (CONTROLLER, LEARNER) == ("tcp/127.0.0.1:7447", "tcp/127.0.0.1:7448")
    for endpoint in (CONTROLLER, LEARNER):
        assert check_endpoint(endpoint) == endpoint


@pytest.mark.parametrize(
    "endpoint",
    [
        "tcp/127.0.0.1:1",
        "tcp/127.0.0.1:65535",
        "tcp/robot.local:7447",
        "tcp/[::1]:7447",
        "udp/10.0.0.1:7447",
        "tls/example.org:443",
        "unixsock-stream//run/tsd.sock",
    ],
)
def test_endpoints_are_accepted_unchanged(endpoint: str) -> None:
    assert check_endpoint(endpoint) == endpoint


@pytest.mark.parametrize(
    "endpoint",
    [
        "",
        "7447",
        "127.0.0.1:7447",
        "tcp://127.0.0.1:7447",  # a URL, the likeliest mistake
        "tcp/127.0.0.1",
        "tcp/127.0.0.1:",
        "tcp/127.0.0.1:0",
        "tcp/127.0.0.1:65536",
        "tcp/127.0.0.1:-1",
        "tcp/127.0.0.1:port",
        "tcp/127.0.0.1: 7447",
        "tcp/127.0.0.1:7447 ",
        " tcp/127.0.0.1:7447",
        "tcp/127.0.0.1:7447\n",
        "http/127.0.0.1:80",
        "TCP/127.0.0.1:7447",
        "tcp/",
        "/127.0.0.1:7447",
    ],
)
def test_what_cannot_be_an_endpoint_is_refused_with_an_example(endpoint: str) -> None:
    with pytest.raises(InvalidValue, match=r"for instance tcp/127\.0\.0\.1:7447") as caught:
        check_endpoint(endpoint)
    assert caught.value.field == "endpoint"
    assert caught.value.value == repr(endpoint)


@pytest.mark.parametrize("low_latency", [False, True])
def test_sessions_never_look_for_others_and_listen_only_where_told(low_latency: bool) -> None:
    settings = session_settings(listen=[CONTROLLER], low_latency=low_latency)
    values = {key: json.loads(value) for key, value in settings.items()}
    assert values["scouting/multicast/enabled"] is False
    assert values["scouting/gossip/enabled"] is False
    assert values["listen/endpoints"] == [CONTROLLER]
    assert values["connect/endpoints"] == []
    assert values["transport/shared_memory/enabled"] is False
    assert session_settings()["listen/endpoints"] == "[]"


def test_low_latency_is_off_unless_asked_for() -> None:
    assert "transport/unicast/lowlatency" not in session_settings()
    settings = session_settings(low_latency=True)
    assert settings["transport/unicast/lowlatency"] == "true"
    assert settings["transport/unicast/qos/enabled"] == "false"


@pytest.mark.parametrize("low_latency", [False, True])
def test_zenoh_takes_every_setting(low_latency: bool) -> None:
    config = zenoh.Config()
    settings = session_settings(listen=[LEARNER], connect=[CONTROLLER], low_latency=low_latency)
    for key, value in settings.items():
        config.insert_json5(key, value)
        assert json.loads(config.get_json(key)) is not None


@pytest.mark.parametrize("chosen", [None, "(rx:(worker_threads:3))"])
def test_the_users_choice_of_threads_is_kept(
    monkeypatch: pytest.MonkeyPatch, chosen: str | None
) -> None:
    monkeypatch.delenv("ZENOH_RUNTIME", raising=False)
    if chosen is not None:
        monkeypatch.setenv("ZENOH_RUNTIME", chosen)
    configure_runtime()
    assert os.environ["ZENOH_RUNTIME"] == (chosen or RUNTIME)


@pytest.mark.parametrize(
    "endpoint",
    [
        "tcp/127.0.0.1:²",  # a digit to str.isdigit, not to int
        "tcp/127.0.0.1:٧٤٤٧",
        "tcp/:7447",
        "unixsock-stream//run/tsd.sock\n",
    ],
)
def test_odd_endpoints_are_refused(endpoint: str) -> None:
    with pytest.raises(InvalidValue):
        check_endpoint(endpoint)
