"""What went on in a stretch of ticks, as a DiagnosticArray of ROS 2."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from tsd_casadi.state import Matrix, Vector
from tsd_casadi.tick.format import Status, TickFormat
from tsd_casadi.tick.missed import Cause
from tsd_casadi.tick.row_state import AT_LIMIT, NO_INEQUALITY, RowState, name_row
from tsd_clients.logs.cdr import CdrMessage

OK, WARN, ERROR = 0, 1, 2


@dataclass(frozen=True)
class Diagnosis:
    """One DiagnosticStatus.

    Attributes:
        name: What it is about.
        level: OK, WARN or ERROR.
        message: In words.
        values: In numbers.
    """

    name: str
    level: int
    message: str
    values: Mapping[str, str] = field(default_factory=dict)


def diagnose(
    columns: Mapping[str, Vector], known: TickFormat, vetoes: Sequence[str]
) -> list[Diagnosis]:
    """Say what went on.

    Args:
        columns: Of the ticks; see ``tick_columns``.
        known: Of the controller.
        vetoes: Why the feedforward was dropped, if it was.
    """
    lap, share = int(columns["lap"][-1]), float(columns["share"][-1])
    phased_in = "share unknown" if np.isnan(share) else f"{100 * share:.0f} % phased in"
    return [
        Diagnosis("tsd: lap", OK, "holding" if lap < 0 else f"lap {lap}", {"lap": str(lap)}),
        Diagnosis(
            "tsd: feedforward",
            WARN if vetoes else OK,
            "; ".join(vetoes) or phased_in,
            {"share": f"{share:.3f}"},
        ),
        _periods(columns["missed"]),
        _controller(columns["status"]),
        _limits(columns, known),
    ]


def diagnostic_array(stamp: tuple[int, int], diagnoses: Sequence[Diagnosis], robot: str) -> bytes:
    """Write the message.

    Args:
        stamp: Seconds and nanoseconds.
        diagnoses: What it says.
        robot: Name of the robot, whose hardware it is about.
    """
    message = CdrMessage()
    message.add("I", *stamp)
    message.add_string("")
    message.add("I", len(diagnoses))
    for each in diagnoses:
        message.add("b", each.level)
        for text in (each.name, each.message, robot):
            message.add_string(text)
        message.add("I", len(each.values))
        for key, value in each.values.items():
            message.add_string(key)
            message.add_string(value)
    return message.content


def _periods(missed: Vector) -> Diagnosis:
    counts = {cause.words: int(np.sum(missed == cause)) for cause in Cause}
    found = {words: count for words, count in counts.items() if count}
    text = ", ".join(f"{count} missed, {words}" for words, count in found.items())
    return Diagnosis("tsd: periods", WARN if found else OK, text or "all answered", _texts(found))


def _controller(status: Vector) -> Diagnosis:
    counts = {each.name.lower(): int(np.sum(status == each)) for each in Status if each}
    found = {name: count for name, count in counts.items() if count}
    text = ", ".join(f"{count} ticks {name}" for name, count in found.items())
    return Diagnosis("tsd: controller", ERROR if found else OK, text or "solved", _texts(found))


def _limits(columns: Mapping[str, Vector], known: TickFormat) -> Diagnosis:
    """Count the ticks at each limit; a joint on its stop is a warning, a foot's force is not."""
    counts = active_limits(columns["active"], known)
    at_limit = np.isin(np.abs(columns["joint_limits"]), AT_LIMIT).any()
    text = ", ".join(counts) or "none active"
    return Diagnosis("tsd: limits", WARN if at_limit else OK, text, _texts(counts))


def active_limits(active: Matrix, known: TickFormat) -> dict[str, int]:
    """Count the ticks in which each inequality was at its bound, by its name.

    Args:
        active: (N, rows), as in replies; NaN where there was none.
        known: Of the controller.
    """
    states = np.abs(np.nan_to_num(active)).astype(int)
    counts: dict[str, int] = {}
    for place in np.flatnonzero((~np.isin(states, NO_INEQUALITY)).any(axis=0)):
        for state in np.unique(states[:, place]):
            if state not in NO_INEQUALITY:
                name = name_row(known.row_names[place], RowState(state))
                counts[name] = counts.get(name, 0) + int(np.sum(states[:, place] == state))
    return counts


def _texts(counts: Mapping[str, int]) -> dict[str, str]:
    return {name: str(count) for name, count in counts.items()}
