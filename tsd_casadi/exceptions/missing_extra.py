"""Something was asked for that needs an extra of the installation."""

from __future__ import annotations

from tsd_casadi.exceptions.base import TsdError


class MissingExtra(TsdError):
    """A library that only an extra brings is not installed.

    Attributes:
        extra: Name of the extra.
        library: What is missing.
    """

    code = "missing_extra"
    extra: str | None = None
    library: str | None = None

    def __init__(self, wanted: str, library: str, extra: str) -> None:
        """Create the error for what was asked for."""
        self.extra, self.library = extra, library
        super().__init__(
            f"{wanted} needs {library}, which is not installed; "
            f"pip install 'tsd_casadi[{extra}]' (in a clone: pip install '.[{extra}]') brings it"
        )
