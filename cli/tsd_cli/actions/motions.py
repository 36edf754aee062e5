"""The motions there are, and what a robot can do of one."""

from __future__ import annotations

from typing import Any

from tsd_casadi.motions.catalogue import find_motion, shipped_motions
from tsd_casadi.motions.described import check_described
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.parameter import Parameter
from tsd_casadi.motions.ranges import range_of, usual_of
from tsd_casadi.repetition.repeat import usual_axes
from tsd_casadi.robot.robot import load_robot
from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import RobotOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.motion_tables import print_motion, print_motions


@interruptible()
def show_motions(output: JsonOptions) -> None:
    """List the shipped motions.

    Raises:
        TsdError: If the output cannot be written.
    """
    check_outputs(output)
    motions = [_describe(kind) for kind in shipped_motions().values()]
    put_out({"motions": motions}, output, lambda: print_motions(motions))


@interruptible()
def show_one(name: str, options: RobotOptions, output: JsonOptions) -> None:
    """Show a motion as one robot can do it.

    Raises:
        TsdError: If there is no such motion, or the robot has no task for it.
    """
    check_outputs(output)
    robot, kind = load_robot(options.robot), find_motion(name)
    check_described(robot, kind)
    described = _describe(kind)
    for parameter, item in zip(described["parameters"], kind.declaration().parameters, strict=True):
        parameter["low"], parameter["high"] = range_of(robot, kind, item)
        taken = "usual" if item.default is None else "default"
        parameter[taken] = usual_of(robot, kind, item)
    sample = kind(**{item.name: _sample(item) for item in kind.declaration().parameters})
    described |= {
        "robot": robot.name,
        "axes": list(sample.axes(robot)),
        "usual_axes": list(usual_axes(robot, sample)),
    }
    put_out(described, output, lambda: print_motion(described))


def _describe(kind: type[Motion]) -> dict[str, Any]:
    declaration = kind.declaration()
    return {
        "name": declaration.motion,
        "version": declaration.version,
        "meaning": (kind.__doc__ or "").split("\n", maxsplit=1)[0].rstrip("."),
        "parameters": [
            {
                "name": item.name,
                "unit": item.unit,
                "meaning": item.meaning,
                "default": item.default,
                "usual": item.usual,
            }
            for item in declaration.parameters
        ],
    }


def _sample(item: Parameter) -> float:
    """Choose a value at which the axes can be asked for: they do not depend on it."""
    return item.default if item.default is not None else max(item.low, 0.0)
