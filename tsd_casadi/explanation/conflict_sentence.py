"""A set of limits that cannot hold together in one sentence, for a message."""

from __future__ import annotations

from collections.abc import Mapping

from tsd_casadi.explanation.row_words import describe_row
from tsd_casadi.tick.row_state import JOINT_ROW

# rows in a sentence; more are counted
FEW = 4


def tell_conflict(conflict: Mapping[str, float]) -> str:
    """Name the rows, those that would have to give way least first.

    Args:
        conflict: By how much each row of the set would have to give way alone, by name,
            of either sign; not empty.
    """
    rows = sorted(((name, abs(alone)) for name, alone in conflict.items()), key=lambda row: row[1])
    main = [row for row in rows if not row[0].startswith(JOINT_ROW)]
    shown = (main or rows)[:FEW]
    others = len(rows) - len(shown)
    rest = f" and {others} other rows" if others else ""
    listed = ", ".join(_tell(name, alone) for name, alone in shown)
    return f"these limits cannot hold together: {listed}{rest}"


def _tell(name: str, alone: float) -> str:
    return f"{name} (short of {alone:.3g} {describe_row(name).unit} by itself)"
