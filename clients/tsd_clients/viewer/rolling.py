"""The newest rows of a run, as one array."""

from __future__ import annotations

import numpy as np

from tsd_casadi.state import Matrix


class Rolling:
    """Keeps the newest rows, and hands them out without copying."""

    def __init__(self, most: int, size: int) -> None:
        """Keep so many rows of a size."""
        self._most = most
        # twice as long as what is kept: it is moved to the front when the end is reached
        self._rows = np.empty((2 * most, size))
        self._end = 0

    def add(self, rows: Matrix) -> None:
        """Take in rows, the newest last.

        Args:
            rows: (m, size).
        """
        rows = rows[-self._most :]
        if self._end + len(rows) > len(self._rows):
            kept = self.rows[len(rows) - self._most :] if len(rows) < self._most else rows[:0]
            self._rows[: len(kept)] = kept.copy()
            self._end = len(kept)
        self._rows[self._end : self._end + len(rows)] = rows
        self._end += len(rows)

    @property
    def rows(self) -> Matrix:
        """What is kept, the newest last, (m, size)."""
        return self._rows[max(0, self._end - self._most) : self._end]
