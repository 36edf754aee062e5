"""Whether what a robot file says of motions is about motions that there are."""

from __future__ import annotations

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import did_you_mean
from tsd_casadi.motions.catalogue import shipped_motions
from tsd_casadi.motions.motion import Motion, declared_parameters
from tsd_casadi.robot.robot import Robot


def check_described(robot: Robot, kind: type[Motion] | None = None) -> None:
    """Refuse sections of a robot file that narrow nothing.

    A name that resembles no shipped motion's is that of somebody's own, whose
    parameters are known once it is asked for.

    Args:
        kind: What is asked for.

    Raises:
        RobotFileError: If a motion is misspelt, or a parameter unknown; it names
            the field.
    """
    described = robot.description.motions
    if not described:
        return
    known = dict(shipped_motions())
    if kind is not None:
        known[kind.name] = kind
    for name, part in described.items():
        field = f"motions.{name}"
        if name not in known:
            meant = did_you_mean(name, known)
            if not meant:
                continue
            raise RobotFileError(
                robot.path, field, "is no motion", f"one of {', '.join(known)}{meant}"
            )
        parameters = [item.name for item in declared_parameters(known[name])]
        for parameter in part.ranges:
            if parameter not in parameters:
                raise RobotFileError(
                    robot.path,
                    f"{field}.{parameter}",
                    f"is no parameter of the {name}",
                    f"one of {', '.join(parameters)}{did_you_mean(parameter, parameters)}",
                )
