"""The log of a run cannot be written or read."""

from __future__ import annotations

from pathlib import Path

from tsd_casadi.exceptions.base import TsdError


class LogError(TsdError):
    """What keeps a run from being written down, or a log from being read."""


class LogNotWritten(LogError):
    """A log could not be begun, or ends before its run did.

    Attributes:
        path: The file.
        reason: What its writer said.
    """

    code = "log_not_written"
    path: Path | None = None
    reason: str | None = None

    def __init__(self, path: Path, reason: str) -> None:
        """Create the error for one file."""
        self.path, self.reason = path, reason
        super().__init__(
            f"the log '{path}' could not be written: {reason}; "
            "what is in it is read after 'tsd log recover'"
        )


class LogNotWhole(LogError):
    """A log ends in the middle, since its writer was killed.

    Attributes:
        path: The file.
    """

    code = "log_not_whole"
    path: Path | None = None

    def __init__(self, path: Path, found: str) -> None:
        """Create the error for one file."""
        self.path = path
        super().__init__(
            f"the log '{path}' is not whole ({found}); 'tsd log recover {path}' keeps what can be "
            "read of it"
        )
