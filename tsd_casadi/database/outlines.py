"""Entries without their weights, a page of all there are."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.database.damaged_entry import DamagedEntry
from tsd_casadi.learning.entry import Entry


@dataclass(frozen=True)
class Outlines:
    """What was found, in the order of the numbers.

    Attributes:
        entries: Their iterations have weights of no columns, (k, 0).
        damaged: Those whose rows are not as they were written.
        more: Number of the others that were asked for, beyond the page.
    """

    entries: list[Entry]
    damaged: list[DamagedEntry]
    more: int = 0
