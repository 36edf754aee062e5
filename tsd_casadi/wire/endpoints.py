"""Where services listen and how sessions are set up, without any discovery.

Sessions never scout and listen only where they are told to, so nothing leaves
the machine unless an endpoint says so. Whoever listens is a service and takes in
queries only: without an access list it would relay the answers of any session
that declares itself on the same keys.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Sequence

from tsd_casadi.exceptions import InvalidValue

CONTROLLER = "tcp/127.0.0.1:7447"
LEARNER = "tcp/127.0.0.1:7448"

# One worker for all of Zenoh's threads: a tick then crosses fewer threads, which
# shortens the round trip and most of all its tail. Not to be combined with batching
# switched off.
RUNTIME = (
    "(rx:(worker_threads:1),tx:(handover:rx),net:(handover:rx),acc:(handover:rx),app:(handover:rx))"
)

# What another session may not send to a service: nothing is relayed, whatever the
# key, so that a stranger's torque never reaches a client over the service's link.
# It guards this link only; where a router stands between, TLS and roles are needed.
REFUSED = [
    "declare_queryable",
    "reply",
    "put",
    "delete",
    "declare_subscriber",
    "liveliness_token",
]
ACCESS = {
    "enabled": True,
    "default_permission": "allow",
    "rules": [
        {
            "id": "foreign",
            "permission": "deny",
            "flows": ["ingress"],
            "messages": REFUSED,
            "key_exprs": ["**"],
        }
    ],
    "subjects": [{"id": "all"}],
    "policies": [{"rules": ["foreign"], "subjects": ["all"]}],
}

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


def configure_runtime() -> None:
    """Choose Zenoh's threads, unless the user did; before the first session."""
    os.environ.setdefault("ZENOH_RUNTIME", RUNTIME)


def session_settings(
    *, listen: Sequence[str] = (), connect: Sequence[str] = (), low_latency: bool = False
) -> dict[str, str]:
    """Write the settings of a Zenoh session, as JSON by configuration key.

    Args:
        listen: Endpoints to listen on; whoever does takes in nothing but queries.
        connect: Endpoints to connect to.
        low_latency: Leave out batching and priorities on the transport. Both
            ends must ask for it, otherwise the usual transport is used; then
            no message may exceed 64 kB.

    Returns:
        Values for ``zenoh.Config.insert_json5``.
    """
    settings: dict[str, object] = {
        "mode": "peer",
        "listen/endpoints": list(listen),
        "listen/exit_on_failure": True,
        "connect/endpoints": list(connect),
        "connect/exit_on_failure": False,
        "connect/timeout_ms": 500,
        "connect/retry": {
            "period_init_ms": 100,
            "period_max_ms": 500,
            "period_increase_factor": 2,
        },
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        # no gain at these sizes, and a stalled receiver loses queries silently
        "transport/shared_memory/enabled": False,
        # a peer that stopped reading is given up soon, so that others do not wait [us]
        "transport/link/tx/queue/congestion_control/block/wait_before_close": 200_000,
        # a frozen peer is noticed after this [ms]
        "transport/link/tx/lease": 1000,
    }
    if listen:
        settings["access_control"] = ACCESS
    if low_latency:
        settings["transport/unicast/lowlatency"] = True
        settings["transport/unicast/qos/enabled"] = False
    return {key: json.dumps(value) for key, value in settings.items()}
