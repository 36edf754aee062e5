"""A database entry: the iterations learned for one motion, and which is served."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tsd_casadi.encoding.laps import FittedLaps, fit_laps
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import IncompatibleEntry
from tsd_casadi.learning.axis_error import plain_errors, unit_of_axis
from tsd_casadi.learning.bound import Bound
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.epochs import (
    about_change,
    about_hardware,
    about_rest,
    hardware_of,
    is_other_hardware,
    newest_epoch,
    recall,
    shows_change,
    since_change,
)
from tsd_casadi.learning.feedback_loop import find_loop
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.instruction import USUAL, Instruction
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.iterative_learning import design_filters
from tsd_casadi.learning.learning_filter import LearningFilter
from tsd_casadi.learning.measured_errors import with_scatter
from tsd_casadi.learning.observed_contraction import last_observed, observe_contractions
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.robot_change import Observation
from tsd_casadi.learning.rules.guarded import Guarded
from tsd_casadi.learning.rules.rule import Rule
from tsd_casadi.learning.trusted_share import trusted_share
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.state import Matrix

SAME_WEIGHTS = 1e-12  # m/s^2


@dataclass
class Entry:
    """All iterations of one motion with its parameters.

    Attributes:
        key: What it is for.
        basis: The basis of all its weights.
        circumstances: Of the newest recording.
        declaration: What is said of the motion; None if nobody did.
        iterations: In the order in which they were made.
        learning_gain: Share of the change that is made next, as the rules set it.
        rule: The rule of the newest recording.
        identifier: Number in the database, 0 before it is stored.
        updated: When it was changed last, ISO 8601, UTC.
        sequence: Counts the recordings of a database; 0 for what was not recorded there.
    """

    key: EntryKey
    basis: PeriodicBasis
    circumstances: Circumstances
    declaration: Declaration | None = None
    iterations: list[Iteration] = field(default_factory=list)
    learning_gain: float = 1.0
    rule: Rule = field(default_factory=Guarded)
    identifier: int = 0
    updated: str = ""
    sequence: int = 0

    @property
    def best(self) -> Iteration:
        """The tested iteration with the smallest error at the newest gains.

        Errors at other gains, or of the robot before it changed, say nothing about
        the weights.
        """
        current = since_change(self.iterations)
        comparable = [item for item in current if item.gains == self.circumstances.gains]
        return min(comparable or current, key=lambda iteration: iteration.error)

    @property
    def epoch(self) -> int:
        """How often the robot has changed since the first recording."""
        return newest_epoch(self.iterations)

    @property
    def served(self) -> Iteration:
        """The iteration that a query is answered with."""
        return self.rule.served(since_change(self.iterations)[-1], self.best)

    def feedforward(self) -> Feedforward:
        """Answer a query with what is served."""
        served = self.served
        provenance: dict[str, Any] = {
            "entries": [self.identifier],
            "iteration": served.number,
            "tested": served.errors is not None,
            "errors": None if served.errors is None else plain_errors(served.errors),
            "gains": {name: list(gains) for name, gains in self.circumstances.gains.items()},
            "axes": list(self.key.axes),
            "context": dict(vars(self.key.context)),
            "epoch": served.epoch,
            "version": self.circumstances.version,
            "updated": self.updated,
        }
        return Feedforward(
            axes=self.key.axes,
            basis=self.basis,
            weights=served.weights.copy(),  # the entry may be kept
            standard_deviations=np.zeros_like(served.weights)
            if served.uncertainty is None
            else served.uncertainty.copy(),
            kind="learned",
            parameters=dict(self.key.parameters),
            provenance=provenance,
            declaration=self.declaration,
        ).within(self.bound)

    def parent(self, iteration: Iteration) -> Iteration | None:
        """Find the iteration that another was learned from."""
        return next((i for i in self.iterations if i.number == iteration.learned_from), None)

    @property
    def bound(self) -> Bound:
        """How large what is served may be, by the repetitions that it comes from or used it."""
        served = self.served
        parent = self.parent(served)
        recorded = [served] if parent is None else [served, parent]
        return Bound.of(self.key.axes, self.basis, recorded, self.circumstances.allowed)

    def add(self, recording: Recording, instruction: Instruction = USUAL) -> list[str]:
        """Take in one repetition: note its errors, then learn from it.

        Args:
            instruction: By which rule, and whether to learn; whoever keeps the
                entries restarts them.

        Returns:
            Remarks for the user.

        Raises:
            InvalidValue: If the recording lacks what the rule needs.
            IncompatibleEntry: If key or basis differ from the entry's.
        """
        instruction.rule.check(recording)
        notes = self._compare(recording)
        before, now = hardware_of(self.iterations), recording.circumstances.hardware
        is_other = is_other_hardware(before, now)
        self.circumstances = recording.circumstances
        self.declaration = recording.declaration or self.declaration
        self.rule = instruction.rule
        fitted = fit_laps(recording.laps, self.basis)
        seen = Observation(self.key.axes, self.basis, recording.applied, fitted)
        used, recalled = self._find(recording.applied), None
        if is_other or shows_change(self.iterations, used, seen, self.circumstances.gains):
            used = self._begin_epoch(used)
            if self.rule.compares:
                recalled = recall(self.iterations, seen, self.circumstances.gains)
            why = about_hardware(before, now) if is_other else about_rest(used)
            notes.append(about_change(why, used, recalled))
        is_first_test = used.errors is None
        self._note(used, recording, fitted)
        best = self.best
        goes_on = self.rule.goes_on_from(used, best)
        if is_first_test:
            self.learning_gain = self.rule.gain_after(self.learning_gain, goes_on)
        if not goes_on:
            notes.append(
                f"iteration {used.number} is worse than iteration {best.number} "
                f"({_told(used)} against {_told(best)}): "
                f"serving {best.number} again, learning gain now {self.learning_gain:g}"
            )
        elif instruction.update:
            self.iterations.append(
                self._learn(used, fitted) if recalled is None else self._recall(recalled)
            )
        return notes

    def filters(self) -> tuple[LearningFilter, ...]:
        """Design what the stable rule would learn with now, one filter per axis.

        Empty while no iteration was tested with known position errors, or if
        nobody said at which frequency, P and D.
        """
        if not any(each.error_weights is not None for each in self.iterations):
            return ()  # in a list for instance, for which no weights are decoded
        tests = self._tests(self.best)
        repetitions = [test.repetition for test in tests if test.repetition is not None]
        if not repetitions:
            return ()
        loop = find_loop(self.key.axes, dict(self.key.parameters), self.circumstances.gains)
        return design_filters(repetitions, self.basis, *loop) if loop else ()

    def observed_contractions(self, axis: int = 0) -> Matrix | None:
        """Compute what each test left of the feedback of the one that it was learned from.

        Returns:
            As ``observe_contractions`` does.
        """
        return observe_contractions(self.key, self.basis, self.iterations, axis)

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
                observed=last_observed(self.key, self.basis, self.iterations, index),
            )
            for index, learning_filter in enumerate(filters)
        )

    def _begin_epoch(self, used: Iteration) -> Iteration:
        """Start again from what was used: errors of before count no more.

        Returns:
            The iteration that was used, the first one of the new epoch.
        """
        epoch, self.learning_gain = self.epoch + 1, 1.0
        if used.errors is None:
            used.epoch = epoch
            return used
        self.iterations.append(replace(self._copy(used), epoch=epoch))
        return self.iterations[-1]

    def _recall(self, recalled: Iteration) -> Iteration:
        """Take an iteration again; what its repetition showed says how large it may be."""
        return replace(self._copy(recalled), learned_from=recalled.number)

    def _copy(self, iteration: Iteration) -> Iteration:
        """Make the next iteration of weights that were there before."""
        return Iteration(
            number=self.iterations[-1].number + 1,
            weights=iteration.weights,
            epoch=self.epoch,
            uncertainty=iteration.uncertainty,
        )

    def _learn(self, used: Iteration, fitted: FittedLaps) -> Iteration:
        """Make the next iteration of what a repetition showed."""
        weights = self.rule.next_weights(
            self.key, self.basis, self._tests(used), fitted.feedback, self.learning_gain
        )
        uncertainty = None if fitted.scatter is None else fitted.scatter.uncertainty(self.basis.L)
        if self.rule.compares:
            share = trusted_share(fitted, used.uncertainty, self.basis)[:, None]
            weights = used.weights + share * (weights - used.weights)
            uncertainty = None if uncertainty is None else np.sqrt(share) * uncertainty
        return Iteration(
            number=self.iterations[-1].number + 1,
            weights=weights,
            learned_from=used.number,
            epoch=self.epoch,
            uncertainty=uncertainty,
        )

    def _note(self, used: Iteration, recording: Recording, fitted: FittedLaps) -> None:
        """Write into an iteration what its repetition showed."""
        used.errors = with_scatter(recording.errors, recording.laps, fitted.scatter)
        used.circumstances = recording.circumstances
        used.feedback = fitted.feedback
        # those of an earlier test of the same weights do not go with the new gains
        used.error_weights, used.reference_weights = fitted.error, fitted.reference

    def _tests(self, last: Iteration) -> list[Iteration]:
        """List the iterations tested at the newest gains, the one to go on from at the end."""
        tested = [
            item for item in since_change(self.iterations) if item.gains == self.circumstances.gains
        ]
        return [*(item for item in tested if item is not last), last]

    def _find(self, applied: Matrix) -> Iteration:
        if not self.iterations:
            self.iterations.append(Iteration(0, np.zeros_like(applied)))
        for iteration in since_change(self.iterations):
            if np.max(np.abs(iteration.weights - applied)) < SAME_WEIGHTS:
                return iteration
        served = self.served
        if served.errors is None and (
            np.max(np.abs(self.bound.apply(served.weights, self.basis) - applied)) < SAME_WEIGHTS
        ):
            # served within its bound, and tested so
            served.weights = applied
            return served
        # applied from elsewhere, for instance generalised
        number = self.iterations[-1].number + 1
        self.iterations.append(Iteration(number, applied, epoch=self.epoch))
        return self.iterations[-1]

    def _compare(self, recording: Recording) -> list[str]:
        if recording.key != self.key:
            raise IncompatibleEntry(
                f"a recording of {recording.key.describe()} for the entry {self.key.describe()}: "
                "another robot, motion, version, axes or context; record it as another entry"
            )
        if recording.basis != self.basis:
            raise IncompatibleEntry(
                f"the entry {self.key.describe()} has a basis of L = {self.basis.L}, width "
                f"{self.basis.width:g}, the recording one of L = {recording.basis.L}, width "
                f"{recording.basis.width:g}; use the same basis, or restart the entry"
            )
        notes = []
        if recording.circumstances.gains != self.circumstances.gains:
            notes.append(
                f"gains differ from the entry's: {recording.circumstances.gains} against "
                f"{self.circumstances.gains}"
            )
        return notes


def _told(iteration: Iteration) -> str:
    """RMS errors by axis for people: 'com.z 0.12 mm, torso.rz 0.3 mrad'."""
    return ", ".join(
        f"{axis} {1e3 * error.rms:.4g} m{unit_of_axis(axis)}"
        for axis, error in (iteration.errors or {}).items()
    )
