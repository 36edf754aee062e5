"""An entry that cannot be read any more, told without keeping the others from being read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tsd_casadi.exceptions import DatabaseError


@dataclass(frozen=True)
class DamagedEntry:
    """An entry that cannot be read.

    Attributes:
        identifier: Its number.
        reason: What is wrong with it.
        parameters: Of the motion, as in a key; None if they are damaged too.
    """

    identifier: int
    reason: str
    parameters: tuple[tuple[str, float], ...] | None = None

    def may_be(self, parameters: tuple[tuple[str, float], ...]) -> bool:
        """Say whether it may be the entry of these parameters of the same motion."""
        return self.parameters in (None, parameters)

    def error(self, path: Path) -> DatabaseError:
        """Make the error of whoever needs it.

        Args:
            path: The file.
        """
        return DatabaseError(
            path,
            f"holds a damaged entry {self.identifier} ({self.reason})",
            f"restore a copy, or 'tsd database forget {self.identifier}'; the others stay readable",
        )
