"""Tables of the motions there are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.markup import escape

from tsd_clients.console.table import Column, console, print_table


def print_motions(motions: Sequence[Mapping[str, Any]]) -> None:
    """Print motions with their parameters, one parameter per row.

    Args:
        motions: With 'name', 'meaning' and 'parameters'; each of them with 'name',
            'unit', 'meaning', 'default' and 'usual'.
    """
    rows = [
        (motion if index == 0 else None, parameter)
        for motion in motions
        for index, parameter in enumerate(motion["parameters"])
    ]
    columns = [
        Column("motion", [_text(motion, "name") for motion, _ in rows], is_text=True),
        *_columns([parameter for _, parameter in rows]),
        Column("what", [_text(motion, "meaning") for motion, _ in rows], rank=2, is_text=True),
    ]
    print_table("", columns)


def print_motion(motion: Mapping[str, Any]) -> None:
    """Print one motion on one robot.

    Args:
        motion: As for ``print_motions``, with 'robot', 'axes', 'usual_axes', and 'low'
            and 'high' of each parameter.
    """
    parameters = motion["parameters"]
    title = f"{motion['name']}, version {motion['version']}: {motion['meaning']}"
    columns = [
        *_columns(parameters),
        *(Column(end, [f"{each[end]:.4g}" for each in parameters]) for end in ("low", "high")),
    ]
    print_table(f"{title}; range on {motion['robot']}", columns)
    axes, usual = (", ".join(motion[name]) for name in ("axes", "usual_axes"))
    console.print(f"moves {axes}; learns {usual} unless --axes says otherwise", highlight=False)


def _columns(parameters: Sequence[Mapping[str, Any]]) -> list[Column]:
    def default(parameter: Mapping[str, Any]) -> str:
        # what a command that moves the robot takes where nothing is said
        value = parameter["usual"] if parameter["default"] is None else parameter["default"]
        return "" if value is None else f"{value:.4g}"

    return [
        Column("parameter", [each["name"] for each in parameters], is_text=True),
        Column("unit", [each["unit"] for each in parameters], is_text=True),
        Column("default", [default(each) for each in parameters]),
        Column("meaning", [escape(each["meaning"]) for each in parameters], rank=1, is_text=True),
    ]


def _text(motion: Mapping[str, Any] | None, name: str) -> str:
    return "" if motion is None else escape(motion[name])
