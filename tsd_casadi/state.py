"""The state of a floating-base robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class State:
    """Configuration and velocity in Pinocchio's conventions.

    Attributes:
        q: Base position in the world [m], base orientation as a quaternion
            xyzw, joint angles [rad], shape (7 + n,).
        v: Base linear velocity in the base frame [m/s], base angular velocity
            in the base frame [rad/s], joint velocities [rad/s], shape (6 + n,).
    """

    q: Vector
    v: Vector

    def __repr__(self) -> str:
        """Say where the base is, how many joints there are and whether it moves."""
        base = " ".join(f"{x:.3f}" for x in self.q[:3])
        speed = float(np.linalg.norm(self.v))
        return f"<State: base at {base} m, {len(self.q) - 7} joints, |v| {speed:.3g}>"
