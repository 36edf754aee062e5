"""The paper's sum, whatever comes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.iterative_learning import update_weights
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.state import Matrix


@dataclass(frozen=True)
class Plain:
    """Always goes on from the newest repetition, by all that its feedback added."""

    name: ClassVar[RuleName] = "plain"
    patience: ClassVar[int | None] = None
    is_by_harmonic: ClassVar[bool] = False
    compares: ClassVar[bool] = False

    def check(self, recording: Recording) -> None:
        """Take every recording."""

    def goes_on_from(self, tested: Iteration, best: Iteration) -> bool:
        """Go on, though it may be worse than an earlier one."""
        return True

    def gain_after(self, gain: float, goes_on: bool) -> float:
        """Leave alone what this rule does not use."""
        return gain

    def next_weights(
        self,
        key: EntryKey,
        basis: PeriodicBasis,
        tests: Sequence[Iteration],
        feedback: Matrix,
        gain: float,
    ) -> Matrix:
        """Add all of the feedback to the applied weights, whatever the gain."""
        return update_weights(tests[-1].weights, feedback)

    def served(self, newest: Iteration, best: Iteration) -> Iteration:
        """Serve the newest, though it may have proved worse."""
        return newest
