"""What this computer does not have."""

from __future__ import annotations

from tsd_casadi.exceptions.base import TsdError


class NotAvailable(TsdError):
    """Something was asked for that needs what this computer does not have.

    Attributes:
        what: What was asked for.
        missing: What it needs.
        remedy: What to do.
    """

    code = "not_available"
    what: str | None = None
    missing: str | None = None
    remedy: str | None = None

    def __init__(self, what: str, missing: str, remedy: str) -> None:
        """Name what was asked for, what is missing and what to do."""
        super().__init__(f"{what} needs {missing}: {remedy}")
        self.what = what
        self.missing = missing
        self.remedy = remedy
