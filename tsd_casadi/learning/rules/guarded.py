"""The paper's sum, never going on from what proved worse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.comparison import is_worse
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.iterative_learning import update_weights
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.state import Matrix


@dataclass(frozen=True)
class Guarded:
    """Serves the best again and halves the change when an iteration proves worse."""

    name: ClassVar[RuleName] = "guarded"
    patience: ClassVar[int | None] = None
    is_by_harmonic: ClassVar[bool] = False
    compares: ClassVar[bool] = True

    def check(self, recording: Recording) -> None:
        """Take every recording."""

    def goes_on_from(self, tested: Iteration, best: Iteration) -> bool:
        """Go on from what is no worse than the best, beyond noise."""
        return not is_worse(tested, best)

    def gain_after(self, gain: float, goes_on: bool) -> float:
        """Halve it after a worse one: the sum would overshoot again."""
        return gain if goes_on else gain / 2

    def next_weights(
        self,
        key: EntryKey,
        basis: PeriodicBasis,
        tests: Sequence[Iteration],
        feedback: Matrix,
        gain: float,
    ) -> Matrix:
        """Add a share of the feedback to the applied weights."""
        return update_weights(tests[-1].weights, feedback, gain)

    def served(self, newest: Iteration, best: Iteration) -> Iteration:
        """Serve the newest, unless it proved worse than the best."""
        return best if newest.errors is not None and is_worse(newest, best) else newest
