"""The robots that come with the project."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_casadi.motions.catalogue import shipped_motions
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.table import Column, console, print_table
from tsd_models import robot_files


@interruptible()
def show_robots(output: JsonOptions) -> None:
    """List the shipped robots.

    Raises:
        TsdError: If the output cannot be written.
    """
    check_outputs(output)
    robots = [_describe(name) for name in robot_files()]
    put_out({"robots": robots}, output, lambda: _print(robots))


def _describe(name: str) -> dict[str, Any]:
    try:
        robot = load_robot(name)
    except RobotFileError as error:
        # its description is in a package that is not there
        empty: dict[str, list[str]] = {
            key: [] for key in ("joints", "contacts", "tasks", "motions")
        }
        # without the file, which is another for each robot: the reason may be the same
        missing = str(error).removeprefix(f"{error.path}: ")
        return {"name": name, **empty, "file": str(error.path), "missing": missing}
    description = robot.description
    return {
        "name": robot.name,
        "joints": robot.joint_names,
        "contacts": [contact.name for contact in description.contacts],
        "tasks": [task.name for task in description.all_tasks],
        "motions": _possible(robot),
        "file": str(robot.path),
    }


def _possible(robot: Robot) -> list[str]:
    """List the shipped motions for which the robot has tasks."""
    possible = []
    for name, kind in shipped_motions().items():
        items = kind.declaration().parameters
        sample = kind(**{item.name: max(item.low, item.default or 0.0) for item in items})
        with suppress(InvalidValue):
            sample.axes(robot)
            possible.append(name)
    return possible


def _print(robots: list[dict[str, Any]]) -> None:
    def listed(name: str) -> list[str]:
        return [", ".join(robot[name]) for robot in robots]

    columns = [
        Column("robot", [robot["name"] for robot in robots], is_text=True),
        # of what is not there nobody knows how many
        Column("joints", [str(len(robot["joints"]) or "-") for robot in robots]),
        Column("contacts", listed("contacts"), rank=1, is_text=True),
        Column("tasks", listed("tasks"), rank=2, is_text=True),
        Column("motions", listed("motions"), is_text=True),
        Column("file", [robot["file"] for robot in robots], rank=3, is_text=True),
    ]
    print_table("", columns)
    missing: dict[str, list[str]] = {}
    for robot in robots:
        if "missing" in robot:
            missing.setdefault(robot["missing"], []).append(robot["name"])
    for reason, names in missing.items():
        console.print(f"{', '.join(names)}: {reason}", highlight=False, markup=False)
