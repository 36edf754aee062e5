"""How sessions are set up: without any discovery, and so that nobody holds up the others.

Sessions never scout and listen only where they are told to, so nothing leaves
the machine unless an endpoint says so. Whoever listens is a service and takes in
queries only: without an access list it would relay the answers of any session
that declares itself on the same keys.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

# One worker for all of Zenoh's threads: a tick then crosses fewer threads, which
# shortens the round trip and most of all its tail. Who connects is let in by another:
# a thousand connections at once would otherwise stop the ticks for 0.1 s. Not to be
# combined with batching switched off.
RUNTIME = (
    "(rx:(worker_threads:1),tx:(handover:rx),net:(handover:rx),acc:(worker_threads:1),"
    "app:(handover:rx))"
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
# A run is watched by subscribers, who may declare themselves and still send nothing.
REFUSED_BY_A_RUN = [each for each in REFUSED if each != "declare_subscriber"]


def _access(refused: Sequence[str]) -> dict[str, Any]:
    return {
        "enabled": True,
        "default_permission": "allow",
        "rules": [
            {
                "id": "tsd-foreign",
                "permission": "deny",
                "flows": ["ingress"],
                "messages": list(refused),
                "key_exprs": ["**"],
            }
        ],
        "subjects": [{"id": "tsd-anybody"}],
        "policies": [{"rules": ["tsd-foreign"], "subjects": ["tsd-anybody"]}],
    }


ACCESS = _access(REFUSED)
RUN_ACCESS = _access(REFUSED_BY_A_RUN)
# A reply is sent the way its query asks for, and a query asks by default that the
# sender wait. A controller does not: a reply for which its client has no room is dropped.
# A learner's may be megabytes, for which a healthy client has no room at once: there the
# client has to take some within ``wait_before_close``, else its link is closed.
REPLIES_DROPPED = {
    "id": "tsd-droppable",
    "messages": ["query"],
    "flows": ["ingress"],
    "key_exprs": ["**"],
    "overwrite": {"congestion_control": "drop"},
}
# for the two round trips in which a client says who it is [ms]; six times the longest
# round trip of a network that a control loop could be closed over
ACCEPT_TIMEOUT = 1000
# the same from the client's side, where Zenoh waits 0.1 s more for a bad certificate [ms]
OPEN_TIMEOUT = 1500
# how many may be in the middle of that; one more is turned away. Four times the
# thousand silent connections that a running client is measured beside
ACCEPT_PENDING = 4000
# of batches that wait for the link of one client. A tick's answer takes two, and a client
# that reads has no more than four ticks under way: where fewer fit, a moment in which
# the machine is busy would pass for a client that does not read
QUEUE = 16
# what the kernel keeps for a client that does not read [bytes], 100 replies of the
# largest robot here; more would only arrive later
SEND_BUFFER = 262_144


def configure_runtime() -> None:
    """Choose Zenoh's threads, unless the user did; before the first session."""
    os.environ.setdefault("ZENOH_RUNTIME", RUNTIME)


def session_settings(
    *,
    listen: Sequence[str] = (),
    connect: Sequence[str] = (),
    service: Literal["controller", "learner", "run"] | None = None,
) -> dict[str, Any]:
    """Write the settings of a Zenoh session.

    Args:
        listen: Endpoints to listen on.
        connect: Endpoints to connect to.
        service: Which one's they are: it takes in queries and nothing else, and does
            not wait for clients that do not read or do not say who they are. A run
            that is watched takes in subscribers, too. None for a client.

    Returns:
        A document as in Zenoh's configuration files.
    """
    transport: dict[str, Any] = {
        # no gain at these sizes, and a stalled receiver loses queries silently
        "shared_memory": {"enabled": False},
        "link": {
            "tx": {
                # a frozen peer is noticed after this [ms]
                "lease": 1000,
                # a peer that stopped reading is given up soon, so that others do not
                # wait [us]
                "queue": {"congestion_control": {"block": {"wait_before_close": 200_000}}},
            }
        },
    }
    settings: dict[str, Any] = {
        "mode": "peer",
        "listen": {"endpoints": list(listen), "exit_on_failure": True},
        "connect": {
            "endpoints": list(connect),
            "exit_on_failure": False,
            "timeout_ms": 500,
            "retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 2},
        },
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "transport": transport,
    }
    # a service that is frozen says nothing; closing a session waits for that [ms]
    transport["unicast"] = {"open_timeout": OPEN_TIMEOUT}
    if service is not None:
        settings["access_control"] = RUN_ACCESS if service == "run" else ACCESS
        transport["unicast"]["accept_timeout"] = ACCEPT_TIMEOUT
        transport["unicast"]["accept_pending"] = ACCEPT_PENDING
        transport["link"]["tcp"] = {"so_sndbuf": SEND_BUFFER}
        transport["link"]["tx"]["queue"]["size"] = {"data": QUEUE}
    if service in ("controller", "run"):
        settings["qos"] = {"network": [REPLIES_DROPPED]}
    if service == "run":
        # what a subscriber has no room for is dropped at once, not after 1 ms [us]
        control = transport["link"]["tx"]["queue"]["congestion_control"]
        control["drop"] = {"wait_before_drop": 0}
    return settings


def merged(settings: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Change settings: sections field by field, all else as a whole.

    Args:
        changes: Go before the settings.
    """
    result = dict(settings)
    for name, value in changes.items():
        before = result.get(name)
        if isinstance(before, Mapping) and isinstance(value, Mapping):
            value = merged(before, value)
        result[name] = value
    return result
