r"""What a motion is: one class that declares its parameters and says where its axes go.

.. math:: x_{ref} = x_{middle} + s(t) f(\phi), \qquad \dot\phi = \Omega

with f periodic and a quintic s that rises from 0 to 1 over the first half lap,
with zero velocity and acceleration at both ends. Offsets of translations are
metres in world axes; those of rotations are rotation vectors in world axes
about the middle orientation.
"""

from __future__ import annotations

import abc
import dataclasses
import math
from typing import ClassVar, NamedTuple

from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.motions.parameter import Parameter
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector


class Offset(NamedTuple):
    """Where the axes are, relative to the middle, as functions of the phase.

    Attributes:
        x: f, (k,) [m, rad].
        by_phase: df/dphi, (k,).
        by_phase_twice: d2f/dphi2, (k,).
    """

    x: Vector
    by_phase: Vector
    by_phase_twice: Vector


class Reference(NamedTuple):
    """Where the axes should be at one time, relative to the middle.

    Attributes:
        x: (k,) [m, rad].
        xd: (k,) [m/s, rad/s].
        xdd: (k,) [m/s^2, rad/s^2].
    """

    x: Vector
    xd: Vector
    xdd: Vector


class Motion(abc.ABC):
    """A periodic motion of some axes; a subclass is a frozen dataclass of its parameters.

    Attributes:
        name: A word of the command line and of queries.
        version: Changed whenever the motion itself changes.
        start_phase: Phase at which the first lap starts [rad].
        frequency: Laps per second [Hz], a parameter of every motion.
    """

    name: ClassVar[str]
    version: ClassVar[str] = "1"
    start_phase: ClassVar[float] = 0.0

    frequency: float

    @abc.abstractmethod
    def axes(self, robot: Robot) -> tuple[str, ...]:
        """Give the names 'task.axis' of the axes that move, k of them."""

    @abc.abstractmethod
    def offset(self, phase: float) -> Offset:
        """Compute where they are at a phase [rad], in the order of ``axes``."""

    def middle(self, robot: Robot) -> State:
        """Compute the posture that the motion is about, at rest; home unless it says otherwise."""
        return robot.home

    @classmethod
    def declaration(cls) -> Declaration:
        """Describe name, version and parameters as data."""
        return Declaration(cls.name, cls.version, declared_parameters(cls))

    @property
    def parameters(self) -> dict[str, float]:
        """What tells this motion from its variations, by name, SI units."""
        return {
            item.name: float(getattr(self, item.name)) for item in declared_parameters(type(self))
        }

    def reference(self, elapsed: float) -> Reference:
        """Compute the reference after some phase since the start.

        Args:
            elapsed: phi minus the starting phase [rad]; the middle before 0.

        Returns:
            Offsets from the middle with their exact derivatives by time.
        """
        omega = 2 * math.pi * self.frequency
        offset = self.offset(self.start_phase + elapsed)
        xd, xdd = omega * offset.by_phase, omega**2 * offset.by_phase_twice
        if elapsed >= math.pi:
            return Reference(offset.x, xd, xdd)
        s, sd, sdd = _smooth_step(elapsed / math.pi)
        # derivatives of s by time: its argument runs at omega / pi
        sd, sdd = sd * omega / math.pi, sdd * (omega / math.pi) ** 2
        return Reference(
            x=s * offset.x,
            xd=sd * offset.x + s * xd,
            xdd=sdd * offset.x + 2 * sd * xd + s * xdd,
        )


def declared_parameters(motion: type[Motion]) -> tuple[Parameter, ...]:
    """List the parameters of a motion's class, in its order."""
    return tuple(
        dataclasses.replace(field.metadata["parameter"], name=field.name)
        for field in dataclasses.fields(motion)  # type: ignore[arg-type]
        if "parameter" in field.metadata
    )


def _smooth_step(x: float) -> tuple[float, float, float]:
    """Quintic from 0 to 1 on [0, 1] with its two derivatives."""
    if x <= 0:
        return 0.0, 0.0, 0.0
    if x >= 1:
        return 1.0, 0.0, 0.0
    return (
        x**3 * (10 - 15 * x + 6 * x**2),
        30 * x**2 * (1 - x) ** 2,
        60 * x * (1 - x) * (1 - 2 * x),
    )
