"""What there is of a tick that was not answered in time: why, as far as it can be told."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Cause(enum.IntEnum):
    """Why a period had no answer; 0 in a log stands for none of them.

    NOTHING_THERE: the question came back at once, there is no controller or no
    way to it. ERROR: what came cannot be used: the controller's own defect, a
    reply that is none, or one of an instance that is not believed. LATE: the
    period was over first, whether controller, network or this computer was slow.
    REFUSED: the controller does not accept state or command.
    """

    NOTHING_THERE = 1
    ERROR = 2
    LATE = 3
    REFUSED = 4

    @property
    def words(self) -> str:
        """The cause for people: 'nothing there'."""
        return self.name.lower().replace("_", " ")


@dataclass(frozen=True, slots=True)
class Missed:
    """A tick without an answer.

    Attributes:
        cause: Why.
        detail: What else is known, for people; empty for nothing.
    """

    cause: Cause
    detail: str = ""

    def __str__(self) -> str:
        """Tell cause and detail."""
        return f"{self.cause.words}: {self.detail}" if self.detail else self.cause.words
