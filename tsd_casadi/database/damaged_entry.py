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
    """

    identifier: int
    reason: str

    @classmethod
    def of(cls, identifier: int, error: Exception) -> DamagedEntry:
        """Take the reason from an error of reading it."""
        return cls(identifier, " ".join(str(error).split()))

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
