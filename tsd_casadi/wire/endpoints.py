"""Where services listen."""

from __future__ import annotations

import re
from ipaddress import ip_address

from tsd_casadi.exceptions import InvalidValue

CONTROLLER = "tcp/127.0.0.1:7447"
LEARNER = "tcp/127.0.0.1:7448"

_ENDPOINT = re.compile(
    r"(tcp|udp|tls|quic|ws)/(?P<host>\[[0-9a-fA-F:.%]+\]|[^\s/:]+):(?P<port>[0-9]{1,5})"
    r"|unixsock-stream/[^\s]+",
    re.ASCII,
)


def check_endpoint(endpoint: str) -> str:
    """Refuse what cannot be an endpoint.

    Args:
        endpoint: For instance 'tcp/127.0.0.1:7447'.

    Returns:
        The endpoint.

    Raises:
        InvalidValue: If it is none.
    """
    match = _ENDPOINT.fullmatch(endpoint)
    if match is None or not 0 < int(match["port"] or 1) < 65536:
        raise InvalidValue(
            "endpoint", repr(endpoint), "PROTOCOL/ADDRESS:PORT, for instance tcp/127.0.0.1:7447"
        )
    return endpoint


def is_of_this_machine(endpoint: str) -> bool:
    """Whether only programs on this machine can reach an endpoint.

    A name is not looked up: what it stands for may change, so that of the machine's
    own loopback counts alone.

    Args:
        endpoint: One that ``check_endpoint`` accepts.
    """
    match = _ENDPOINT.fullmatch(endpoint)
    if match is None or match["host"] is None:
        return endpoint.startswith("unixsock-stream/")
    host = match["host"].strip("[]")
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
