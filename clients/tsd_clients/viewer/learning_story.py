"""How learning went at one entry: errors by iteration, epochs, what changed last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.state import Vector
from tsd_casadi.wire.learner import EntryMessage, IterationMessage
from tsd_casadi.wire.telemetry import IterationRecorded
from tsd_clients.viewer.prediction import PHASE

# errors that are zero have no place on a logarithmic axis; 1 nm is nothing of a robot's [m, rad]
SMALLEST = 1e-9
# of an error: two lines that are closer lie on one another
SEEN = 0.02


@dataclass(frozen=True)
class ErrorHistory:
    """Errors of one axis in the order of the iterations, NaN where one was not tested.

    Attributes:
        number: Of each iteration.
        rms: RMS error as the controller sees it [m, rad].
        deviation: Standard deviation of the RMS error of a single lap [m, rad]; zero
            where nobody knows it.
        true_rms: RMS error of the robot itself [m, rad].
        epoch: Counts how often the robot had changed before.
    """

    number: Vector
    rms: Vector
    deviation: Vector
    true_rms: Vector
    epoch: Vector

    @classmethod
    def of(cls, iterations: Sequence[IterationMessage], axis: str) -> ErrorHistory:
        """Collect the errors of an entry along one axis."""
        errors = [(each.errors or {}).get(axis) for each in iterations]

        def known(name: str, missing: float) -> Vector:
            values = [None if each is None else getattr(each, name) for each in errors]
            return np.array([missing if each is None else each for each in values], dtype=float)

        return cls(
            number=np.array([each.number for each in iterations], dtype=float),
            rms=np.maximum(known("rms", np.nan), SMALLEST),
            deviation=known("deviation", 0.0),
            true_rms=np.maximum(known("true_rms", np.nan), SMALLEST),
            epoch=np.array([each.epoch for each in iterations], dtype=float),
        )

    @property
    def has_deviation(self) -> bool:
        """Whether it is known how well the errors repeat."""
        return bool((self.deviation > 0).any())

    @property
    def true_differs(self) -> bool:
        """Whether the true errors are known, and others than those that the controller sees."""
        known = np.isfinite(self.true_rms) & np.isfinite(self.rms)
        off = np.abs(self.true_rms[known] - self.rms[known])
        return bool((off > SEEN * self.rms[known]).any())

    @property
    def repeatability(self) -> tuple[Vector, Vector]:
        """Between what a single lap's RMS error lies two times of three [m, rad].

        The lower end stops at a tenth of the error: on a logarithmic axis nothing more
        can be seen.
        """
        low = np.maximum(self.rms - self.deviation, np.maximum(self.rms / 10, SMALLEST))
        return low, self.rms + self.deviation

    @property
    def epochs_begin(self) -> list[float]:
        """Numbers between iterations at which the robot had changed."""
        changed = np.flatnonzero(np.diff(self.epoch) > 0)
        return [float(self.number[index] + self.number[index + 1]) / 2 for index in changed]


@dataclass(frozen=True)
class Change:
    """What one iteration changed, as curves over the phase.

    Attributes:
        before: What was fed forward, at ``PHASE`` [unit/s^2].
        after: What is served from then on; the same where nothing was learned.
    """

    before: Vector
    after: Vector


def change_of(recorded: IterationRecorded, axis: str) -> Change:
    """Compute what an iteration changed along one of its axes."""
    basis, row = recorded.basis.basis(), recorded.axes.index(axis)
    after = recorded.before if recorded.after is None else recorded.after
    before, now = (basis.evaluate(PHASE, [each[row]])[0] for each in (recorded.before, after))
    return Change(before, now)


def told(entry: EntryMessage, recorded: IterationRecorded | None) -> list[str]:
    """Say how it stands with an entry, for people."""
    tested = [each for each in entry.iterations if each.errors is not None]
    said = [f"rule {entry.rule}; learning gain {entry.learning_gain:g}"]
    if tested:
        first, last = tested[0].errors or {}, tested[-1].errors or {}
        said += [
            f"{axis}: {1e3 * first[axis].rms:.3g} → {1e3 * last[axis].rms:.3g} "
            f"m{unit_of_axis(axis)} RMS"
            for axis in last
            if axis in first
        ]
    epochs = max((each.epoch for each in entry.iterations), default=0)
    if epochs:
        said.append(f"the robot changed {epochs} times: epochs are apart in the chart")
    return said + ([] if recorded is None else list(recorded.notes))


def shares_of(contraction: Contraction) -> dict[str, Vector]:
    """Give what an iteration leaves of each harmonic, by name; NaN where nobody knows."""
    shares = {
        "plain sum": contraction.plain,
        "predicted": contraction.predicted,
        "observed": contraction.observed,
    }
    return {
        name: np.array([np.nan if each is None else each for each in values], dtype=float)
        for name, values in shares.items()
    }
