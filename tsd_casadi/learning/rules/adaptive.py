"""Stable, and going by how much of the last change arrived."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.adaptive_learning import update_adaptively
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.feedback_loop import require_loop
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.learning.rules.stable import Stable
from tsd_casadi.state import Matrix


@dataclass(frozen=True)
class Adaptive(Stable):
    """Learns where friction and rotor inertia take most of a change away.

    Needs what the rule 'stable' needs.
    """

    name: ClassVar[RuleName] = "adaptive"

    def next_weights(
        self,
        key: EntryKey,
        basis: PeriodicBasis,
        tests: Sequence[Iteration],
        feedback: Matrix,
        gain: float,
    ) -> Matrix:
        """Learn from the last two repetitions, see ``update_adaptively``."""
        loop = require_loop(key.axes, dict(key.parameters), tests[-1].gains or {})
        repetitions = [test.repetition for test in tests if test.repetition is not None]
        return update_adaptively(repetitions, basis, *loop, gain=gain)
