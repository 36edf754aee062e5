"""Whether a recording can be what a robot did: refused with the reason before anybody learns.

The laps of a recording come from anywhere, and what is learned of them moves a robot.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.axis_error import AxisError, unit_of_axis
from tsd_casadi.learning.bound import LARGEST_ACCELERATION
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.recording import Recording
from tsd_casadi.state import Matrix, Vector

# of a basis that is learned: a lap of a robot has no hundred harmonics
MOST_FUNCTIONS = 200
# samples times functions, 64 MB while they are fitted: five minutes at 1 kHz with the usual 25
MOST_NUMBERS = 8_000_000
# who is further from the reference has fallen
LARGEST_ERROR = {"m": 0.5, "rad": np.pi / 2}
# ten times what a humanoid's motions are
LARGEST_PARAMETER = {"m": 10.0, "rad": 20 * np.pi, "Hz": 50.0}
# of a loop of 100 Hz, faster than any that a robot's joints follow; critical damping is 2 sqrt P
LARGEST_GAIN = {"P": (2 * np.pi * 100) ** 2, "D": 4 * np.pi * 100}
# of feedback and feedforward together: laps further from their median have nothing in common
# that could be fed forward
MOST_DISAGREEMENT = 0.5
# below it laps may disagree: noise where next to nothing is to be learned
NEGLIGIBLE = {"m": 0.2, "rad": 2.0}
# of feedback and of P e + D de/dt, the larger: filters, delays and time steps between the two
# are worth a tenth, another sign, another unit or another axis is worth all of it
MOST_UNEXPLAINED = 0.5
# laps are compared by means over so many parts, at most
PARTS = 24


def check_plausible(recording: Recording) -> None:
    """Refuse a recording that cannot be what a robot did.

    Raises:
        InvalidValue: If it is not, with the reason.
    """
    axes, basis, laps = recording.key.axes, recording.basis, recording.laps
    check_size(laps, basis)
    for index, lap in enumerate(laps):
        check_phase(lap.phase, basis, f"lap {index}")
    check_parameters(recording)
    check_errors(recording.errors)
    check_circumstances(recording.circumstances, axes)
    check_amounts(axes, laps, recording.applied)
    check_agreement(axes, laps, basis, recording.applied)
    check_feedback_law(recording)


def check_size(laps: Sequence[Lap], basis: PeriodicBasis) -> None:
    """Refuse what would keep a learner busy, before it is looked at.

    Raises:
        InvalidValue: If the basis or all samples together are too large.
    """
    if basis.L > MOST_FUNCTIONS:
        raise InvalidValue("L", basis.L, f"at most {MOST_FUNCTIONS} basis functions")
    samples = sum(lap.phase.size for lap in laps)
    if samples * basis.L > MOST_NUMBERS:
        raise InvalidValue(
            "the laps",
            f"{samples} samples for {basis.L} basis functions",
            f"at most {MOST_NUMBERS // basis.L}: fewer laps, or fewer samples of each",
        )


def check_phase(phase: Vector, basis: PeriodicBasis, name: str) -> None:
    """Refuse phases that are not those of one whole lap, in order.

    Args:
        phase: (N,) [rad], wrapped or not.
        name: Of the lap.

    Raises:
        InvalidValue: If they do not advance, leave a gap or are of no whole lap.
    """
    if phase.ndim != 1 or phase.size < 2:
        raise InvalidValue(
            f"phase of {name}", f"of shape {phase.shape}", "one number for each of many samples"
        )
    # an advance of more than half a lap from one sample to the next is one backwards
    steps = (np.diff(phase) + np.pi) % (2 * np.pi) - np.pi
    # a function without a sample near its centre has any weight
    gap = 2 * np.pi / basis.L
    travelled = float(phase.max() - phase.min())
    if abs(travelled - 360) < 36 or abs(np.diff(phase).sum() - 360) < 36:
        raise InvalidValue(f"phase of {name}", f"over {travelled:.4g} rad", "radians, not degrees")
    if (steps <= 0).any():
        at = int(np.argmax(steps <= 0))
        raise InvalidValue(
            f"phase of {name}",
            f"{phase[at]:.4g} rad, then {phase[at + 1]:.4g} rad",
            "phases that advance from sample to sample, by less than half a lap",
        )
    if steps.max() > gap:
        at = int(np.argmax(steps))
        raise InvalidValue(
            f"phase of {name}",
            f"without a sample from {phase[at]:.4g} to {phase[at + 1]:.4g} rad",
            f"steps of at most {gap:.3g} rad, from one basis function to the next",
        )
    if abs(steps.sum() - 2 * np.pi) > gap:
        raise InvalidValue(
            f"phase of {name}", f"over {steps.sum():.4g} rad", "one whole lap, 2 pi rad"
        )


def check_amounts(axes: Sequence[str], laps: Sequence[Lap], applied: Matrix) -> None:
    """Refuse accelerations and errors that no robot has.

    Args:
        applied: Weights in use, (k, L).

    Raises:
        InvalidValue: If one is.
    """
    for index, axis in enumerate(axes):
        unit = unit_of_axis(axis)
        _check_below(f"the applied feedforward of {axis}", applied[index], _acceleration(unit))
        for number, lap in enumerate(laps):
            of = f"of {axis} in lap {number}"
            _check_below(f"the feedback {of}", lap.feedback[index], _acceleration(unit))
            if lap.error is not None:
                _check_below(f"the error {of}", lap.error[index], (LARGEST_ERROR[unit], unit))


def check_parameters(recording: Recording) -> None:
    """Refuse parameters that no motion of a robot has, where their units are known.

    Raises:
        InvalidValue: If one is too large.
    """
    for name, value in recording.key.parameters:
        unit = "" if recording.declaration is None else recording.declaration.unit_of(name)
        largest = LARGEST_PARAMETER.get(unit, np.inf)
        if abs(value) > largest:
            raise InvalidValue(name, f"{value:g} {unit}", f"at most {largest:.4g} {unit}")


def check_errors(errors: Mapping[str, AxisError]) -> None:
    """Refuse RMS errors that no robot has.

    Raises:
        InvalidValue: If one is.
    """
    for axis, error in errors.items():
        unit = unit_of_axis(axis)
        _check_below(f"RMS error of {axis}", np.array([error.rms]), (LARGEST_ERROR[unit], unit))


def check_circumstances(circumstances: Circumstances, axes: Sequence[str]) -> None:
    """Refuse gains that no robot's task has, and limits that are none.

    Raises:
        InvalidValue: If one is negative or too large, or not of the axes.
    """
    gains, allowed = circumstances.gains, circumstances.allowed
    if allowed and len(allowed) != len(axes):
        raise InvalidValue(
            "allowed accelerations", len(allowed), f"one of each of {', '.join(axes)}, or none"
        )
    for axis, acceleration in zip(axes, allowed, strict=False):
        if not 0 < acceleration < np.inf:
            raise InvalidValue(f"allowed acceleration of {axis}", acceleration, "one above 0")
    for name, largest in LARGEST_GAIN.items():
        for gain in gains.get(name, ()):
            if not 0 <= gain <= largest:
                raise InvalidValue(name, f"{gain:g}", f"0 to {largest:.0f}, the task's in SI units")


def check_agreement(
    axes: Sequence[str], laps: Sequence[Lap], basis: PeriodicBasis, applied: Matrix
) -> None:
    """Refuse laps that have nothing in common, and a single one that is unlike the others.

    Args:
        laps: With phases of whole laps.
        applied: Weights in use, (k, L).

    Raises:
        InvalidValue: If a lap is too far from the median of all.
    """
    if len(laps) < 2:
        return
    parts = min(basis.L, PARTS)
    means = np.array([_means(lap.phase, lap.feedback, parts) for lap in laps])
    median = np.median(means, axis=0)
    middles = 2 * np.pi * (np.arange(parts) + 0.5) / parts
    whole = median + basis.evaluate(middles, applied)
    units = [unit_of_axis(axis) for axis in axes]
    for unit in dict.fromkeys(units):
        rows = [index for index, each in enumerate(units) if each == unit]
        # an axis of which next to nothing is asked is measured by the ones beside it
        size = np.sqrt(np.mean(np.sum(whole[rows] ** 2, axis=0)))
        off = np.sqrt(np.mean(np.sum((means - median)[:, rows] ** 2, axis=1), axis=1))
        worst = int(np.argmax(off))
        if off[worst] > max(MOST_DISAGREEMENT * size, NEGLIGIBLE[unit]):
            raise InvalidValue(
                f"the feedback of lap {worst}",
                f"{off[worst]:.3g} {unit}/s^2 RMS away from that of the others",
                f"steady laps, within half of the {size:.3g} {unit}/s^2 that they feed back and "
                "forward",
            )


def check_feedback_law(recording: Recording) -> None:
    """Refuse feedback that is not what the gains make of the errors, where both are known.

    Raises:
        InvalidValue: If it has another sign or another size.
    """
    axes = recording.key.axes
    frequency = dict(recording.key.parameters).get("frequency", 0.0)
    gains = recording.circumstances.gains
    if not (frequency > 0 and gains.get("P") and gains.get("D")):
        return
    # an axis without stiffness or damping obeys it as well, and hides no other
    P, D = (np.array(gains[name])[:, None] for name in ("P", "D"))
    omega = 2 * np.pi * frequency
    parts = min(recording.basis.L, PARTS)
    for number, lap in enumerate(recording.laps):
        if lap.error is None:
            continue
        feedback, error = (_means(lap.phase, values, parts) for values in (lap.feedback, lap.error))
        expected = P * error + D * omega * _derivative(error)
        left, found, made = (_rms(each) for each in (feedback - expected, feedback, expected))
        for index, axis in enumerate(axes):
            unit = unit_of_axis(axis)
            allowed = MOST_UNEXPLAINED * max(found[index], made[index]) + NEGLIGIBLE[unit]
            if left[index] > allowed:
                raise InvalidValue(
                    f"the feedback of {axis} in lap {number}",
                    f"{left[index]:.3g} {unit}/s^2 RMS away from what P and D make of the errors",
                    f"P (x_ref - x) + D (xd_ref - xd), {made[index]:.3g} {unit}/s^2 RMS",
                )


def _derivative(values: Matrix) -> Matrix:
    """Compute the derivative by the phase of what was sampled over a lap, (k, parts)."""
    parts = values.shape[1]
    return np.fft.irfft(1j * np.arange(parts // 2 + 1) * np.fft.rfft(values), parts)


def _rms(values: Matrix) -> Vector:
    return np.asarray(np.sqrt(np.mean(values**2, axis=1)))


def _means(phase: Vector, values: Matrix, parts: int) -> Matrix:
    """Compute the means in equal parts of a lap, (k, parts)."""
    part = np.floor(phase % (2 * np.pi) / (2 * np.pi) * parts).astype(int) % parts
    # steps are no longer than a part, so that next to none is empty
    count = np.maximum(np.bincount(part, minlength=parts), 1)
    sums = [np.bincount(part, weights=row, minlength=parts) for row in values]
    return np.array(sums) / count


def _acceleration(unit: str) -> tuple[float, str]:
    return LARGEST_ACCELERATION[unit], f"{unit}/s^2"


def _check_below(name: str, values: Vector, bound: tuple[float, str]) -> None:
    largest, unit = bound
    found = float(np.abs(values).max(initial=0.0))
    if found > largest:
        raise InvalidValue(name, f"up to {found:.4g} {unit}", f"at most {largest:.4g} {unit}")
