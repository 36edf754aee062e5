"""Tables of what was found wrong with a robot, and of what its motions ask for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.markup import escape

from tsd_clients.console.table import Column, console, print_table

COLORS = {"error": "red", "warning": "yellow", "note": "dim"}


def print_examination(name: str, examination: Mapping[str, Any]) -> None:
    """Print findings, then motions.

    Args:
        name: Of the robot.
        examination: From ``Examination.plain``.
    """
    motions = examination["motions"]
    frequencies = {each["parameters"]["frequency"] for each in motions}
    # said once, it leaves room for the joints' names
    common = frequencies.pop() if len(frequencies) == 1 else None
    at = "" if common is None else f" at {common:.3g} Hz"
    print_table(
        f"{name}: the ends of its motions' ranges, over a lap{at}",
        [
            Column("motion", [_motion(each, common) for each in motions], is_text=True),
            Column("to limit,\nrad", [_part(each, "joint", 1.0, 2) for each in motions]),
            Column("nearest", [_of(each, "joint") for each in motions], rank=1, is_text=True),
            Column("torque\n%", [_part(each, "torque", 100.0, 0) for each in motions]),
            Column("joint", [_of(each, "torque") for each in motions], rank=2, is_text=True),
            Column("friction\n%", [_part(each, "friction", 100.0, 0) for each in motions], rank=3),
            Column("inside\nfeet, mm", [_pressure(each) for each in motions]),
        ],
    )
    if examination["torque_speed"]:
        _print_lines(name, examination["torque_speed"])
    console.print()
    for finding in examination["findings"]:
        color, severity = COLORS[finding["severity"]], finding["severity"]
        console.print(
            f"[{color}]{severity}[/{color}] {escape(finding['element'])} "
            f"{escape(finding['found'])}; {escape(finding['remedy'])}",
            highlight=False,
        )
    errors = sum(finding["severity"] == "error" for finding in examination["findings"])
    others = len(examination["findings"]) - errors
    verdict = "works" if examination["works"] else "cannot work like this"
    console.print(f"{name} {verdict}: {errors} errors, {others} warnings and notes")


def _print_lines(name: str, lines: Sequence[Mapping[str, Any]]) -> None:
    def numbers(field: str) -> list[str]:
        return ["-" if line[field] is None else f"{line[field]:.3g}" for line in lines]

    print_table(
        f"{name}: torque that its motors have left at speed",
        [
            Column("joint", [escape(line["joint"]) for line in lines], is_text=True),
            Column("limit,\nN m", numbers("torque_limit")),
            Column("up to,\nrad/s", numbers("full_torque_speed")),
            Column("at rest,\nN m", numbers("stall_torque"), rank=1),
            Column("none from,\nrad/s", numbers("no_load_speed")),
            Column("allowed,\nrad/s", numbers("velocity_limit"), rank=2),
        ],
    )


def _motion(motion: Mapping[str, Any], common: float | None) -> str:
    values = (
        f"{name}={value:.3g}"
        for name, value in motion["parameters"].items()
        if value and (name != "frequency" or common is None)
    )
    return escape(" ".join([motion["motion"], *values]))


def _part(motion: Mapping[str, Any], name: str, factor: float, digits: int) -> str:
    part = motion[name]
    return "-" if part is None else f"{factor * part['value']:.{digits}f}"


def _pressure(motion: Mapping[str, Any]) -> str:
    return "-" if motion["pressure"] is None else f"{1e3 * motion['pressure']:.0f}"


def _of(motion: Mapping[str, Any], name: str) -> str:
    return "" if motion[name] is None else escape(str(motion[name]["of"]))
