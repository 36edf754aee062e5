"""Who can be asked for a feedforward."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from tsd_casadi.learning.context import Context
from tsd_casadi.learning.feedforward import Feedforward


class FeedforwardSource(Protocol):
    """A database, local or behind a service."""

    def query(
        self,
        motion: str,
        /,
        *,
        robot: str,
        kind: str | None = None,
        extrapolate: bool = False,
        axes: Sequence[str] | None = None,
        context: Context | None = None,
        version: str | None = None,
        **parameters: float,
    ) -> Feedforward:
        """Tell the feedforward for some parameters of a motion."""
