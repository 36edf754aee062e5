"""A database entry: the iterations learned for one task, and which is served."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tsd_casadi.encoding.harmonics import highest_harmonic, to_harmonics
from tsd_casadi.encoding.laps import join_laps, join_positions
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import IncompatibleEntry
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.feedback_loop import FeedbackLoop, find_loop, require_loop
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.iterative_learning import (
    Trial,
    angular_frequencies,
    design_filters,
    update_stably,
    update_weights,
)
from tsd_casadi.learning.learning_filter import LearningFilter
from tsd_casadi.learning.recording import Context, Recording, Rule, TaskKey
from tsd_casadi.state import Matrix, Vector

SAME_WEIGHTS = 1e-12  # m/s^2
# harmonics of the feedback below this say nothing about contraction
SMALLEST_FEEDBACK = 2e-3  # m/s^2


@dataclass
class Iteration:
    """Weights and, once a repetition used them, how well they did.

    Attributes:
        number: 0 for no feedforward, then counting up.
        weights: (k, L) [m/s^2].
        errors: Measures of the repetition that used them, None while untested.
        gains: The gains of that repetition.
        feedback: What its feedback added, fitted, (k, L) [m/s^2].
        error_weights: Its position error, fitted, (k, L) [m]; None if unknown.
        reference_weights: Its reference, fitted, (k, L) [m]; None if unknown.
        learned_from: Number of the iteration whose repetition it was learned
            from, None if it came from elsewhere or is not known.
    """

    number: int
    weights: Matrix
    errors: dict[str, float] | None = None
    gains: dict[str, Any] | None = None
    feedback: Matrix | None = None
    error_weights: Matrix | None = None
    reference_weights: Matrix | None = None
    learned_from: int | None = None

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
        learning_gain: Share of the change that is made next. Every iteration
            that proves worse halves it. With the rule 'stable' every better one
            doubles it again, up to 1: what was worse by noise, or by a response
            that is known better since, is no reason to learn slowly for ever.
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
        self._note(used, recording)
        if recording.rule != "plain" and used.error > self.best.error:
            if is_new:
                self.learning_gain /= 2
            notes.append(
                f"iteration {used.number} is worse than iteration {self.best.number} "
                f"({1e3 * used.error:.4g} mm against {1e3 * self.best.error:.4g} mm RMS): "
                f"serving {self.best.number} again, learning gain now {self.learning_gain:g}"
            )
            return notes
        if recording.rule == "stable" and is_new:
            self.learning_gain = min(1.0, 2 * self.learning_gain)
        if recording.update:
            weights = self._updated(used, recording)
            number = self.iterations[-1].number + 1
            self.iterations.append(Iteration(number, weights, learned_from=used.number))
        return notes

    def filters(self) -> tuple[LearningFilter, ...]:
        """What the stable rule would learn with now, one filter per axis.

        Empty while no iteration was tested with known position errors, or if
        nobody said at which frequency, P and D.
        """
        loop = self._loop(self.context.gains)
        trials = self._trials(self.best) if self.iterations else []
        return design_filters(trials, self.basis, *loop) if loop and trials else ()

    def observed_contractions(self, axis: int = 0) -> Matrix | None:
        """What each test left of the feedback of the one that it was learned from.

        The feedback is C e of the position error where that is known, since the
        measured one lags.

        Args:
            axis: Index of the axis.

        Returns:
            By pair of tests and harmonic, (pairs, N + 1); NaN where the feedback
            was too small to tell; None without a pair.
        """
        by_number: dict[int | None, Iteration] = {item.number: item for item in self.iterations}
        rows = []
        for item in self.iterations:
            before = by_number.get(item.learned_from)
            if before is None or item.errors is None or item.gains != before.gains:
                continue
            left, all_of_it = self._feedback_harmonics(item, before, axis)
            row = np.full_like(left, np.nan)
            rows.append(np.divide(left, all_of_it, out=row, where=all_of_it > SMALLEST_FEEDBACK))
        return np.array(rows) if rows else None

    @property
    def contractions(self) -> tuple[Contraction, ...]:
        """What iterations leave of an error, predicted and observed, by axis.

        Empty where ``filters`` is.
        """
        filters, parameters = self.filters(), dict(self.key.parameters)
        return tuple(
            Contraction.of(
                axis=self.key.axes[index],
                frequency=parameters["frequency"],
                learning_filter=learning_filter,
                learning_gain=self.learning_gain,
                observed=self._last_observed(index),
            )
            for index, learning_filter in enumerate(filters)
        )

    def _last_observed(self, axis: int) -> Vector:
        observed = self.observed_contractions(axis)
        last = np.full(highest_harmonic(self.basis) + 1, np.nan)
        for row in () if observed is None else observed:
            last = np.where(np.isnan(row), last, row)
        return last

    def _feedback_harmonics(self, one: Iteration, other: Iteration, axis: int) -> list[Vector]:
        """|C e| of two tests at the same gains; the measured feedback if errors are unknown."""
        loop = self._loop(one.gains)
        errors = one.error_weights, other.error_weights
        if loop is not None and errors[0] is not None and errors[1] is not None:
            frequency, P, D = loop
            C = P[axis] + 1j * angular_frequencies(self.basis, frequency) * D[axis]
            return [np.abs(C * to_harmonics(self.basis, e)[axis]) for e in errors if e is not None]
        return [
            np.abs(to_harmonics(self.basis, item.feedback)[axis])
            for item in (one, other)
            if item.feedback is not None
        ]

    def _loop(self, gains: dict[str, Any] | None) -> FeedbackLoop | None:
        return find_loop(self.key.axes, dict(self.key.parameters), gains)

    def _note(self, used: Iteration, recording: Recording) -> None:
        """Write into an iteration what its repetition showed."""
        phase, feedback = join_laps(recording.laps)
        used.errors, used.gains = dict(recording.errors), recording.context.gains
        used.feedback = self.basis.fit(phase, feedback)
        # those of an earlier test of the same weights do not go with the new gains
        used.error_weights, used.reference_weights = None, None
        positions = join_positions(recording.laps)
        if positions is not None:
            used.error_weights, used.reference_weights = (
                self.basis.fit(phase, values) for values in positions
            )

    def _updated(self, used: Iteration, recording: Recording) -> Matrix:
        if recording.rule == "stable":
            loop = require_loop(self.key.axes, dict(self.key.parameters), self.context.gains)
            trials = self._trials(used)
            return update_stably(trials, self.basis, *loop, gain=self.learning_gain).weights
        gain = self.learning_gain if recording.rule == "guarded" else 1.0
        return update_weights(recording.applied, recording.laps, self.basis, gain)

    def _trials(self, last: Iteration) -> list[Trial]:
        """Tests at the newest gains, the one to go on from at the end."""
        tested = [item for item in self.iterations if item.gains == self.context.gains]
        ordered = [*(item for item in tested if item is not last), last]
        return [
            Trial(item.weights, item.error_weights, item.reference_weights)
            for item in ordered
            if item.error_weights is not None and item.reference_weights is not None
        ]

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
