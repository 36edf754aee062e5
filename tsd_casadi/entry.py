"""A database entry: the iterations learned for one task, and which is served."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tsd_casadi.exceptions import IncompatibleEntry
from tsd_casadi.feedforward import Feedforward
from tsd_casadi.iterative_learning import update_weights
from tsd_casadi.periodic_basis import PeriodicBasis
from tsd_casadi.recording import Context, Recording, Rule, TaskKey
from tsd_casadi.state import Matrix

SAME_WEIGHTS = 1e-12  # m/s^2


@dataclass
class Iteration:
    """Weights and, once a repetition used them, how well they did.

    Attributes:
        number: 0 for no feedforward, then counting up.
        weights: (k, L) [m/s^2].
        errors: Measures of the repetition that used them, None while untested.
        gains: The gains of that repetition.
    """

    number: int
    weights: Matrix
    errors: dict[str, float] | None = None
    gains: dict[str, Any] | None = None

    @property
    def error(self) -> float:
        """RMS error of the repetition that used them [m]; infinite if untested."""
        return self.errors["rms_error_m"] if self.errors else float("inf")


@dataclass
class Entry:
    """All iterations of one task.

    Attributes:
        key: What it is for.
        basis: The basis of all its weights.
        context: Circumstances of the newest recording.
        iterations: In the order in which they were made.
        learning_gain: Share of the fitted feedback that is added next.
        rule: The rule of the newest recording.
        identifier: Number in the database, 0 before it is stored.
        updated: When it was changed last, ISO 8601, UTC.
    """

    key: TaskKey
    basis: PeriodicBasis
    context: Context
    iterations: list[Iteration] = field(default_factory=list)
    learning_gain: float = 1.0
    rule: Rule = "guarded"
    identifier: int = 0
    updated: str = ""

    @property
    def best(self) -> Iteration:
        """The tested iteration with the smallest error at the newest gains.

        Errors at other gains say nothing about the weights.
        """
        comparable = [item for item in self.iterations if item.gains == self.context.gains]
        return min(comparable or self.iterations, key=lambda iteration: iteration.error)

    @property
    def served(self) -> Iteration:
        """The newest iteration while it is untested, else the best.

        The plain rule serves the newest in any case.
        """
        newest = self.iterations[-1]
        return newest if newest.errors is None or self.rule == "plain" else self.best

    def feedforward(self) -> Feedforward:
        """What a query is answered with."""
        served = self.served
        provenance: dict[str, Any] = {
            "entries": [self.identifier],
            "iteration": served.number,
            "tested": served.errors is not None,
            "errors": served.errors,
            "gains": self.context.gains,
            "formulation": self.context.formulation,
            "model": self.context.model,
            "version": self.context.version,
            "updated": self.updated,
        }
        return Feedforward(
            axes=self.key.axes,
            basis=self.basis,
            weights=served.weights,
            standard_deviations=np.zeros_like(served.weights),
            kind="learned",
            parameters=dict(self.key.parameters),
            provenance=provenance,
        )

    def add(self, recording: Recording) -> list[str]:
        """Take in one repetition: note its errors, then learn from it.

        Args:
            recording: The repetition.

        Returns:
            Remarks for the user.

        Raises:
            IncompatibleEntry: If basis or formulation differ from the entry's.
        """
        notes = self._compare(recording)
        self.context = recording.context
        self.rule = recording.rule
        used = self._find(recording.applied)
        is_new = used.errors is None
        used.errors, used.gains = dict(recording.errors), recording.context.gains
        if recording.rule == "guarded" and used.error > self.best.error:
            if is_new:
                self.learning_gain /= 2
            notes.append(
                f"iteration {used.number} is worse than iteration {self.best.number} "
                f"({1e3 * used.error:.4g} mm against {1e3 * self.best.error:.4g} mm RMS): "
                f"serving {self.best.number} again, learning gain now {self.learning_gain:g}"
            )
            return notes
        if recording.update:
            gain = self.learning_gain if recording.rule == "guarded" else 1.0
            weights = update_weights(recording.applied, recording.laps, self.basis, gain)
            self.iterations.append(Iteration(self.iterations[-1].number + 1, weights))
        return notes

    def _find(self, applied: Matrix) -> Iteration:
        if not self.iterations:
            self.iterations.append(Iteration(0, np.zeros_like(applied)))
        for iteration in self.iterations:
            if np.max(np.abs(iteration.weights - applied)) < SAME_WEIGHTS:
                return iteration
        # applied from elsewhere, for instance generalised
        self.iterations.append(Iteration(self.iterations[-1].number + 1, applied))
        return self.iterations[-1]

    def _compare(self, recording: Recording) -> list[str]:
        if recording.basis != self.basis:
            raise IncompatibleEntry(
                f"the entry {self.key.describe()} has a basis of L = {self.basis.L}, width "
                f"{self.basis.width:g}, the recording one of L = {recording.basis.L}, width "
                f"{recording.basis.width:g}; use the same basis, or restart the entry"
            )
        if recording.context.formulation != self.context.formulation:
            raise IncompatibleEntry(
                f"the entry {self.key.describe()} was learned with formulation "
                f"{self.context.formulation}, the recording has "
                f"{recording.context.formulation}; restart the entry"
            )
        notes = []
        if recording.context.gains != self.context.gains:
            notes.append(
                f"gains differ from the entry's: {recording.context.gains} against "
                f"{self.context.gains}"
            )
        if recording.context.model != self.context.model:
            notes.append(
                f"the controller's model is {recording.context.model}, the entry was learned "
                f"with {self.context.model}"
            )
        return notes
