"""Something that was found while a robot was examined."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

# an error cannot work; a warning works, but worse than it could or not as meant
Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """What was found at one element of a description or robot file.

    Attributes:
        severity: How bad it is.
        element: Where, in words of the description: 'joint L_KFE', 'contact left_foot'.
        found: What is there.
        remedy: What to do about it.
    """

    severity: Severity
    element: str
    found: str
    remedy: str

    def plain(self) -> dict[str, Any]:
        """Give plain data, for JSON."""
        return dict(vars(self))
