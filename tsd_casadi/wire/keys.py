"""The key space of the network: every key name is made here.

::

    tsd/<robot>/controller/tick      state and command -> torque (binary)
    tsd/<robot>/controller/info      dimensions, layouts, limits (JSON)
    tsd/<robot>/learner/feedforward  task parameters -> feedforward (JSON)
    tsd/<robot>/learner/suggestion   a region of them -> where to learn next (JSON)
    tsd/<robot>/learner/record       laps of one repetition -> what was learned (JSON)
    tsd/<robot>/learner/database     what is known (JSON)
    tsd/<robot>/<role>/alive         liveliness token

One learner serves every robot, so its keys have ``*`` for the robot.
"""

from __future__ import annotations

ANY_ROBOT = "*"


def tick_key(robot: str) -> str:
    """Key of the tick."""
    return f"tsd/{robot}/controller/tick"


def info_key(robot: str) -> str:
    """Key of the controller's description."""
    return f"tsd/{robot}/controller/info"


def feedforward_key(robot: str) -> str:
    """Key of learned and generalised feedforward."""
    return f"tsd/{robot}/learner/feedforward"


def suggestion_key(robot: str) -> str:
    """Key of the place to learn at next."""
    return f"tsd/{robot}/learner/suggestion"


def record_key(robot: str) -> str:
    """Key that takes recordings."""
    return f"tsd/{robot}/learner/record"


def database_key(robot: str) -> str:
    """Key of the list of entries."""
    return f"tsd/{robot}/learner/database"


def alive_key(robot: str, role: str) -> str:
    """Key of a service's liveliness token."""
    return f"tsd/{robot}/{role}/alive"


def robot_of(key: str) -> str:
    """The robot's chunk of a key."""
    return key.split("/")[1]
