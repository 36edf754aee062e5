"""What one repetition leaves behind for learning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.state import Matrix


@dataclass(frozen=True)
class Recording:
    """The steady laps of one repetition.

    Attributes:
        key: The entry it belongs to.
        basis: The basis of the applied weights.
        applied: Weights of the feedforward in use, (k, L) [m/s^2].
        laps: Whole steady laps with the feedback term.
        errors: Measures of the repetition, one for each axis of the key, in its order.
        circumstances: How the repetition was made.
        declaration: What is said of the motion; None if nobody did.
    """

    key: EntryKey
    basis: PeriodicBasis
    applied: Matrix
    laps: list[Lap]
    errors: dict[str, AxisError]
    circumstances: Circumstances
    declaration: Declaration | None = None

    def __post_init__(self) -> None:
        """Refuse numbers that nothing can be learned from.

        Raises:
            InvalidValue: If weights, laps, errors or gains are not finite or of the
                wrong shape, or laps are missing.
        """
        if tuple(self.errors) != self.key.axes:
            raise InvalidValue(
                "errors",
                f"of {', '.join(self.errors) or 'no axis'}",
                f"of {', '.join(self.key.axes)}",
            )
        for axis, error in self.errors.items():
            if not (np.isfinite(error.rms) and error.rms >= 0):
                raise InvalidValue(f"RMS error of {axis}", error.rms, "a number not below 0")
        for name in ("P", "D"):
            gains = self.circumstances.gains.get(name)
            if gains is not None and not (
                len(gains) == len(self.key.axes) and np.isfinite(gains).all()
            ):
                raise InvalidValue(
                    name,
                    str(gains)[:100],
                    f"a finite number for each of {', '.join(self.key.axes)}",
                )
        if not self.laps:
            raise InvalidValue("laps", "none", "at least one whole steady lap")
        k = len(self.key.axes)
        _check("the applied weights", self.applied, (k, self.basis.L))
        for index, lap in enumerate(self.laps):
            _check(f"the phase of lap {index}", lap.phase, (lap.phase.size,))
            for values in (lap.feedback, lap.error, lap.reference):
                if values is not None:
                    _check(f"lap {index}", values, (k, lap.phase.size))

    @property
    def has_positions(self) -> bool:
        """Whether every lap says where the robot was, and where it should have been."""
        return all(lap.error is not None and lap.reference is not None for lap in self.laps)

    def along(self, axes: Sequence[str]) -> Recording:
        """Put the learned axes into another order, whatever there is of each.

        Args:
            axes: Those of the key.
        """
        order = [self.key.axes.index(axis) for axis in axes]
        told = self.circumstances
        return replace(
            self,
            key=replace(self.key, axes=tuple(axes)),
            applied=self.applied[order],
            laps=[lap.along(order) for lap in self.laps],
            errors={axis: self.errors[axis] for axis in axes},
            circumstances=replace(
                told,
                gains={name: [each[i] for i in order] for name, each in told.gains.items()},
                allowed=[told.allowed[i] for i in order] if told.allowed else [],
            ),
        )


def _check(name: str, values: Matrix, shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        found, expected = (" x ".join(map(str, each)) for each in (values.shape, shape))
        raise InvalidValue(name, found, f"{expected} numbers, a row for each learned axis")
    if not np.isfinite(values).all():
        raise InvalidValue(name, "not finite", "finite numbers")
