"""What is identified from: a robot's motion, and the friction of its joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsd_casadi.state import Matrix, Vector

# velocity at which Coulomb friction has turned its sign [rad/s]
SLIDING = 0.02


@dataclass(frozen=True)
class Observations:
    """What a robot did, sample by sample, with all feet on the ground.

    Attributes:
        q: (N, nq).
        v: (N, nv).
        a: dv/dt, (N, nv).
        tau: Joint torques, (N, n) [N m].
    """

    q: Matrix
    v: Matrix
    a: Matrix
    tau: Matrix


@dataclass(frozen=True)
class Friction:
    """Friction of the joints.

    Attributes:
        viscous: (n,) [N m s/rad].
        coulomb: (n,) [N m].
    """

    viscous: Vector
    coulomb: Vector

    def torque(self, velocity: Vector) -> Vector:
        """Compute what it takes to move against it.

        Args:
            velocity: Of the joints, (n,) [rad/s].

        Returns:
            (n,) [N m].
        """
        return np.asarray(self.viscous * velocity + self.coulomb * smooth_sign(velocity))


def smooth_sign(velocity: Vector) -> Vector:
    """Compute the sign of joint velocities, smooth where they turn, (n,).

    Args:
        velocity: (n,) [rad/s].
    """
    return np.asarray(np.tanh(velocity / SLIDING))
