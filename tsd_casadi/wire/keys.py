"""The key space of the network: every key name is made here.

::

    tsd/<robot>/controller/tick      state and command -> torque (binary)
    tsd/<robot>/controller/info      dimensions, layouts, limits (JSON)
    tsd/<robot>/learner/feedforward  parameters of a motion -> feedforward (JSON)
    tsd/<robot>/learner/suggestion   a region of them -> where to learn next (JSON)
    tsd/<robot>/learner/record       laps of one repetition -> what was learned (JSON)
    tsd/<robot>/learner/database     what is known (JSON)
    tsd/<robot>/<role>/health        uptime, counts, latencies (JSON)
    tsd/<robot>/<role>/alive         liveliness token

    tsd/<robot>/run/<instance>/rows    what is seen of a repetition's ticks (binary)
    tsd/<robot>/run/<instance>/events  what happens beside them (JSON)
    tsd/<robot>/run/<instance>/story   what has happened so far, for who comes late (JSON)
    tsd/<robot>/run/<instance>/alive   liveliness token

One learner serves every robot, so its keys have ``*`` for the robot.
"""

from __future__ import annotations

import re

from tsd_casadi.exceptions import InvalidValue, MalformedMessage

ANY_ROBOT = "*"
# what may stand for a robot: one chunk of a key, without wildcards in it
_CHUNK = re.compile(r"[^/*$#?@][^/*$#?]*|\*")


def tick_key(robot: str) -> str:
    """Make the key of the tick."""
    return _key(robot, "controller/tick")


def info_key(robot: str) -> str:
    """Make the key of the controller's description."""
    return _key(robot, "controller/info")


def feedforward_key(robot: str) -> str:
    """Make the key of learned and generalised feedforward."""
    return _key(robot, "learner/feedforward")


def suggestion_key(robot: str) -> str:
    """Make the key of the place to learn at next."""
    return _key(robot, "learner/suggestion")


def record_key(robot: str) -> str:
    """Make the key that takes recordings."""
    return _key(robot, "learner/record")


def database_key(robot: str) -> str:
    """Make the key of the list of entries."""
    return _key(robot, "learner/database")


def health_key(robot: str, role: str) -> str:
    """Make the key of how a service is."""
    return _key(robot, f"{role}/health")


def alive_key(robot: str, role: str) -> str:
    """Make the key of a service's liveliness token."""
    return _key(robot, f"{role}/alive")


def rows_key(robot: str, instance: int) -> str:
    """Make the key of what is seen of a run's ticks."""
    return _key(robot, f"run/{instance:x}/rows")


def events_key(robot: str, instance: int) -> str:
    """Make the key of what happens in a run."""
    return _key(robot, f"run/{instance:x}/events")


def story_key(robot: str, instance: int) -> str:
    """Make the key that tells what has happened in a run so far."""
    return _key(robot, f"run/{instance:x}/story")


def run_alive_key(robot: str, instance: int) -> str:
    """Make the key of a run's liveliness token."""
    return alive_key(robot, f"run/{instance:x}")


def robot_of(key: str) -> str:
    """Find the robot's chunk of a key.

    Raises:
        MalformedMessage: If the key has none.
    """
    chunks = key.split("/")
    if len(chunks) < 2:
        raise MalformedMessage(f"key {key}", "a key of 'tsd/<robot>/...'")
    return chunks[1]


def _key(robot: str, rest: str) -> str:
    if _CHUNK.fullmatch(robot) is None:
        raise InvalidValue("robot", repr(robot), "the name of a robot, without any of / * $ # ? @")
    return f"tsd/{robot}/{rest}"
