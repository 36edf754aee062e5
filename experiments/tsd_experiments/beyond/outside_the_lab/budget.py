"""What the errors under noise are made of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tsd_clients.console.table import Column, print_table

RUNS = {
    "after": "learned with noise, used with it",
    "floor": "learned without, used with it",
    "replay": "learned with noise, used without",
}


def print_budget(rows: Sequence[dict[str, Any]]) -> None:
    """Print RMS errors of the row 'noise', and how much of them all laps have in common.

    Args:
        rows: As ``learn_under_noise`` tells them, one for each seed.
    """
    learned = [row for row in rows if row["refused"] is None]
    if not learned:
        return
    columns = [Column("term", list(RUNS.values()), is_text=True)]
    for title, of in (("RMS\nmm", learned), ("repeats\nmm", [row["repeating"] for row in learned])):
        medians = [float(np.median([row[name] for row in of])) for name in RUNS]
        columns.append(Column(title, [f"{value:.3f}" for value in medians]))
    print_table(f"medians of {len(learned)} seeds", columns)
