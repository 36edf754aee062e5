"""A learned or generalised feedforward term."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.band import Band
from tsd_casadi.learning.bound import Bound
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.state import Matrix

Kind = Literal["learned", "generalised", "constant", "nearest", "none"]


@dataclass(frozen=True)
class Feedforward:
    """Accelerations to add to a task's reference, as functions of the phase.

    Attributes:
        axes: Names 'task.axis' of the k axes.
        basis: The basis of the weights.
        weights: (k, L) [m/s^2, rad/s^2].
        standard_deviations: Weights of its predictive standard deviation over
            the phase, (k, L) [m/s^2, rad/s^2]; of a learned entry the standard
            deviation of its weights, zero if unknown.
        kind: How it came about.
        parameters: Of the motion that it is meant for, SI units.
        provenance: Where it comes from, plain data.
        declaration: What is said of the motion; None if nobody did.
        bound: What it was bounded by; None if nobody did.
        bands: That are meant to hold what would be learned; none for what was.
    """

    axes: tuple[str, ...]
    basis: PeriodicBasis
    weights: Matrix
    standard_deviations: Matrix
    kind: Kind
    parameters: dict[str, float] = field(default_factory=dict)
    provenance: dict[str, Any] = field(default_factory=dict)
    declaration: Declaration | None = None
    bound: Bound | None = None
    bands: tuple[Band, ...] = ()

    def __repr__(self) -> str:
        """Say along what, of which kind and for which parameters."""
        kind = f"{self.kind}, iteration {self.iteration}" if self.iteration else self.kind
        given = "".join(f" {name}={value:g}" for name, value in self.parameters.items())
        largest = float(np.abs(self.weights).max(initial=0.0))
        return (
            f"<Feedforward along {', '.join(self.axes)}: {kind}{given}; weights up to "
            f"{largest:.3g} m/s^2>"
        )

    @classmethod
    def zero(cls, axes: tuple[str, ...], basis: PeriodicBasis) -> Feedforward:
        """Feed nothing forward."""
        nothing = np.zeros((len(axes), basis.L))
        return cls(axes, basis, nothing, nothing, "none")

    def within(self, bound: Bound) -> Feedforward:
        """Shrink each axis to a bound, where it is larger."""
        return replace(self, weights=bound.apply(self.weights, self.basis), bound=bound)

    def over(self, axes: tuple[str, ...]) -> Feedforward:
        """Give the same along other axes: zero along those that it does not know."""
        if axes == self.axes:
            return self
        known = {axis: index for index, axis in enumerate(self.axes)}
        rows = [known.get(axis) for axis in axes]

        def pick(weights: Matrix) -> Matrix:
            nothing = np.zeros(self.basis.L)
            return np.array([nothing if row is None else weights[row] for row in rows])

        return replace(
            self,
            axes=axes,
            weights=pick(self.weights),
            standard_deviations=pick(self.standard_deviations),
            bands=tuple(replace(band, half_width=pick(band.half_width)) for band in self.bands),
            bound=None if self.bound is None else self.bound.over(rows),
        )

    @property
    def iteration(self) -> int:
        """Learning iterations behind it; 0 for none."""
        return int(self.provenance.get("iteration", 0))

    @property
    def epoch(self) -> int:
        """How often the robot had changed before it was learned."""
        return int(self.provenance.get("epoch", 0))

    def mean(self, phase: ArrayLike) -> Matrix:
        """Compute the feedforward term.

        Args:
            phase: (N,) [rad].

        Returns:
            (k, N) [m/s^2], world axes.
        """
        return self.basis.evaluate(phase, self.weights)

    def std(self, phase: ArrayLike) -> Matrix:
        """Compute its predictive standard deviation, in the basis of the mean.

        Args:
            phase: (N,) [rad].

        Returns:
            (k, N) [m/s^2].
        """
        return self.basis.evaluate(phase, self.standard_deviations)

    def constant(self) -> Feedforward:
        """Keep only its mean over a lap, what an integrator would settle at."""
        # the basis sums to one, so equal weights are a constant signal
        phase = np.linspace(0, 2 * np.pi, 720, endpoint=False)
        mean = self.mean(phase).mean(axis=1, keepdims=True)
        weights = np.repeat(mean, self.basis.L, axis=1)
        return replace(
            self,
            weights=weights,
            standard_deviations=np.zeros_like(weights),
            kind="constant",
            bands=(),
        )
