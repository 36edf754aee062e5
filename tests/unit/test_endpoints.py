from __future__ import annotations

import pytest

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER, check_endpoint, is_of_this_machine


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


@pytest.mark.parametrize(
    ("endpoint", "expected"),
    [
        ("tcp/127.0.0.1:7447", True),
        ("tcp/127.8.9.1:7447", True),
        ("tcp/[::1]:7447", True),
        ("tls/localhost:7447", True),
        ("unixsock-stream//run/tsd.sock", True),
        ("tcp/0.0.0.0:7447", False),
        ("tcp/[::]:7447", False),
        ("tcp/10.0.0.1:7447", False),
        ("tcp/128.0.0.1:7447", False),
        ("tcp/localhost.example.org:7447", False),
        ("tcp/robot.local:7447", False),
    ],
)
def test_who_can_reach_an_endpoint(endpoint: str, expected: bool) -> None:
    assert is_of_this_machine(check_endpoint(endpoint)) is expected
