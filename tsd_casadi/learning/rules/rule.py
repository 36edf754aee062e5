"""What every learning rule answers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.recording import Recording
from tsd_casadi.state import Matrix

RuleName = Literal["guarded", "plain", "stable", "adaptive"]


class Rule(Protocol):
    """How an entry goes on from one repetition to the next.

    An entry asks in the order of the methods below: may this recording be learned
    from, shall it be, how large is the next change, which weights come next. A
    rule keeps nothing: what was learned is the entry's.
    """

    @property
    def name(self) -> RuleName:
        """Its word in messages, in the database and on the command line."""

    @property
    def patience(self) -> int | None:
        """Iterations in a row without progress after which it is done; None for never."""

    @property
    def is_by_harmonic(self) -> bool:
        """Whether it decides harmonic by harmonic what is learned."""

    @property
    def compares(self) -> bool:
        """Whether it goes by how iterations did, and by how much of that is noise."""

    def check(self, recording: Recording) -> None:
        """Refuse what cannot be learned from by this rule.

        Raises:
            InvalidValue: If the recording lacks what the rule needs.
        """

    def goes_on_from(self, tested: Iteration, best: Iteration) -> bool:
        """Say whether to learn from the repetition that has just tested an iteration.

        Args:
            tested: Has errors now; worse than the best is only what noise does not explain.
            best: Has the smallest error at these gains, perhaps the same one.
        """

    def gain_after(self, gain: float, goes_on: bool) -> float:
        """Say the learning gain after the first test of an iteration.

        Args:
            gain: Before, the share of a change that is made.
            goes_on: What ``goes_on_from`` said of it.
        """

    def next_weights(
        self,
        key: EntryKey,
        basis: PeriodicBasis,
        tests: Sequence[Iteration],
        feedback: Matrix,
        gain: float,
    ) -> Matrix:
        """Compute the weights of the next iteration.

        Args:
            tests: Iterations tested at the gains of the newest recording, the one
                to go on from last.
            feedback: What the feedback of that last test added, fitted, (k, L)
                [m/s^2].
            gain: Share of the change that is made.

        Returns:
            (k, L) [m/s^2].
        """

    def served(self, newest: Iteration, best: Iteration) -> Iteration:
        """Choose the iteration that answers a query.

        Args:
            newest: The last one that was made.
            best: Has the smallest error at the newest gains.
        """
