"""What a simulated robot can have beyond rigid bodies, by name."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_casadi.exceptions.did_you_mean import did_you_mean

if TYPE_CHECKING:  # the help of the command line names the effects without loading a robot
    from tsd_casadi.robot.robot import Robot

ACTUATOR_EFFECTS = ("armature", "friction", "delay", "lag")
SENSOR_EFFECTS = ("quantisation", "noise", "differencing", "flat_feet")
EFFECTS = (*ACTUATOR_EFFECTS, *SENSOR_EFFECTS)


def check_effects(robot: Robot, effects: Collection[str]) -> tuple[str, ...]:
    """Check the names of effects and put them in their usual order.

    Args:
        robot: The robot, whose file must have the numbers.
        effects: Names from ``EFFECTS``, or 'all'.

    Raises:
        InvalidValue: If a name is unknown, or the robot's feet are of two kinds
            and the base is to be estimated from them.
        RobotFileError: If the robot file has no section 'hardware'.
    """
    unknown = [name for name in effects if name not in (*EFFECTS, "all")]
    if unknown:
        close = did_you_mean(unknown[0], EFFECTS)
        expected = f"all, or any of {', '.join(EFFECTS)}{close}"
        raise InvalidValue("hardware", ", ".join(unknown), expected)
    if effects and robot.description.hardware is None:
        raise RobotFileError(
            robot.path, "hardware", "is missing", "its section, or no hardware effects"
        )
    chosen = tuple(name for name in EFFECTS if name in effects or "all" in effects)
    kinds = {contact.type for contact in robot.description.contacts}
    if "flat_feet" in chosen and len(kinds) > 1:
        raise InvalidValue(
            "hardware",
            "flat_feet",
            f"effects without it: it estimates the base from soles or from points, and "
            f"{robot.name} stands on both",
        )
    return chosen
