"""How far a feedforward term may be off."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from tsd_casadi.state import Matrix


@dataclass(frozen=True)
class Band:
    """A band around a feedforward term that is meant to hold what would be learned.

    Attributes:
        kind: 'pointwise' at each phase by itself, 'simultaneous' for whole laps.
        coverage: Share of phases or laps that it is meant to hold.
        half_width: Weights of half its width over the phase, (k, L) [m/s^2, rad/s^2].
    """

    kind: Literal["pointwise", "simultaneous"]
    coverage: float
    half_width: Matrix
