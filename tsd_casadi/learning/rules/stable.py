"""Guarded, and filtered by the estimated response of the loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.feedback_loop import require_loop
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.iterative_learning import update_stably
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.guarded import Guarded
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.state import Matrix


@dataclass(frozen=True)
class Stable(Guarded):
    """Lets nothing grow that lag and delay would make grow.

    Needs to know where the robot was, how fast the laps were and with which gains.
    """

    name: ClassVar[RuleName] = "stable"
    patience: ClassVar[int | None] = 3
    is_by_harmonic: ClassVar[bool] = True

    def check(self, recording: Recording) -> None:
        """Refuse what cannot be filtered.

        Raises:
            InvalidValue: If positions, frequency or gains are not known.
        """
        if not recording.has_positions:
            raise InvalidValue(
                "laps", "without error and reference", "both for the rule 'stable', or another rule"
            )
        key = recording.key
        require_loop(key.axes, dict(key.parameters), recording.circumstances.gains)

    def gain_after(self, gain: float, goes_on: bool) -> float:
        """Halve it after a worse one, double it after a better one, up to 1.

        What was worse by noise, or by a response that is known better since, is no
        reason to learn slowly for ever.
        """
        return min(1.0, 2 * gain) if goes_on else gain / 2

    def next_weights(
        self,
        key: EntryKey,
        basis: PeriodicBasis,
        tests: Sequence[Iteration],
        feedback: Matrix,
        gain: float,
    ) -> Matrix:
        """Learn from all repetitions whose positions are known, see ``update_stably``."""
        loop = require_loop(key.axes, dict(key.parameters), tests[-1].gains or {})
        repetitions = [test.repetition for test in tests if test.repetition is not None]
        return update_stably(repetitions, basis, *loop, gain=gain).weights
