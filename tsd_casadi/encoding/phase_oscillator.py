r"""The phase that references and feedforward share [phi_omega].

.. math:: \dot \phi = \Omega
"""

from __future__ import annotations

import math


class PhaseOscillator:
    """A phase that grows by Omega dt and counts its laps.

    Attributes:
        phase: phi [rad], not wrapped.
        start: phi at the start of the first lap [rad].
    """

    def __init__(self, frequency: float, start: float) -> None:
        """Start at a phase.

        Args:
            frequency: Omega / 2 pi [Hz]; may be changed while running.
            start: Phase to start from [rad].
        """
        self.frequency = frequency
        self.start = start
        self.phase = start

    @property
    def omega(self) -> float:
        """Omega [rad/s]."""
        return 2 * math.pi * self.frequency

    @property
    def elapsed(self) -> float:
        """Phase since the start [rad]."""
        return self.phase - self.start

    @property
    def lap(self) -> int:
        """Laps completed since the start."""
        # rounding: the last of N steps may end a hair before 2 pi
        return math.floor(self.elapsed / (2 * math.pi) + 1e-9)

    def advance(self, dt: float) -> None:
        """Go on by a time step [s]."""
        self.phase += self.omega * dt
