r"""Legs, knees and trunk of a robot, found by how they move rather than by name.

Turning joint j moves the foot's ankle b about the joint's axis, and its squared
distance to the hip a is

.. math:: |b - a|^2 = \mathrm{const} + 2 |a_\perp| |b_\perp| \cos(q_j - q_{long})

with :math:`a_\perp, b_\perp` the parts across the axis. The knee is the joint for
which the product is largest; its bend is counted from :math:`q_{long}`, where the
leg is longest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.state import Vector

# the trunk is followed upwards while it carries this share of what is above the legs: arms
# carry less than half each
CARRIES = 0.6
# thigh times shank in shares of the squared length of the leg: a quarter of it for equal
# parts; hips and ankles whose axes do not meet have less than a tenth
KNEE_SHARE = 0.12


@dataclass(frozen=True)
class Leg:
    """One leg.

    Attributes:
        joints: Pinocchio's indices from hip to ankle.
        knee: Index of the knee.
        straight: Angle of the knee at which the leg is longest [rad].
        sign: Direction in which the knee bends, 1 or -1.
        largest_bend: Bend at the knee's limit [rad].
    """

    joints: tuple[int, ...]
    knee: int
    straight: float
    sign: float
    largest_bend: float

    def bend(self, model: Any, q: Vector) -> float:
        """Compute how far the knee is bent [rad]."""
        return self.sign * (float(q[model.joints[self.knee].idx_q]) - self.straight)


def find_legs(model: Any, feet: tuple[int, int]) -> tuple[Leg, Leg]:
    """Find both legs.

    Args:
        model: ``pinocchio.Model`` with a free-flyer.
        feet: Indices of the feet's joints.

    Raises:
        InvalidValue: If no joint of a leg bends it.
    """
    chains = [list(model.supports[foot])[2:] for foot in feet]
    shared = set(chains[0]) & set(chains[1])
    left, right = (_leg(model, [j for j in chain if j not in shared]) for chain in chains)
    return left, right


def find_pelvis(model: Any, feet: tuple[int, int]) -> int:
    """Find the joint that carries both legs; the base's unless joints are in between."""
    chains = [list(model.supports[foot]) for foot in feet]
    return int(max(set(chains[0]) & set(chains[1])))


def find_trunk(model: Any, feet: tuple[int, int]) -> int:
    """Find the joint whose link carries what is above the legs, arms and head or all of it."""
    legs = {j for foot in feet for j in list(model.supports[foot])} - {1}
    if find_pelvis(model, feet) != 1:
        return 1  # the base is above the hips already
    data = model.createData()
    pinocchio.computeSubtreeMasses(model, data)
    above = [j for j in range(2, model.njoints) if j not in legs]
    moving = sum(data.mass[j] for j in above if model.parents[j] == 1)
    trunk = 1
    while True:
        children = [j for j in above if model.parents[j] == trunk]
        heavy = [j for j in children if data.mass[j] >= CARRIES * moving]
        if not heavy:
            return trunk
        trunk = heavy[0]


def _leg(model: Any, joints: list[int]) -> Leg:
    data = model.createData()
    pinocchio.forwardKinematics(model, data, pinocchio.neutral(model))
    hip, ankle = (np.array(data.oMi[j].translation) for j in (joints[0], joints[-1]))
    shortening = {j: _swing(model, data, j, hip, ankle) for j in joints}
    knee = max(shortening, key=lambda j: shortening[j][0])
    reach, straight = shortening[knee]
    if reach < KNEE_SHARE * float(np.sum((hip - ankle) ** 2)):
        names = ", ".join(str(model.names[j]) for j in joints)
        raise InvalidValue(
            "the leg",
            names,
            "a joint between hip and ankle that bends it; write the robot "
            "file of a robot without knees by hand",
        )
    index = model.joints[knee].idx_q
    low, high = model.lowerPositionLimit[index], model.upperPositionLimit[index]
    forward, backward = high - straight, straight - low
    sign = 1.0 if forward >= backward else -1.0
    return Leg(tuple(joints), knee, straight, sign, float(max(forward, backward)))


def _swing(model: Any, data: Any, joint: int, hip: Vector, ankle: Vector) -> tuple[float, float]:
    """Compute the product of both distances to a joint's axis, and where the leg is longest."""
    placement = data.oMi[joint]
    axis = _axis(model, joint)
    if axis is None:
        return 0.0, 0.0
    local = [placement.actInv(point) for point in (hip, ankle)]
    a, b = (point - (point @ axis) * axis for point in local)
    # the neutral angle is zero; from b to the far side of a about the axis
    angle = math.atan2(float(np.cross(b, -a) @ axis), float(b @ -a))
    return float(np.linalg.norm(a) * np.linalg.norm(b)), angle


def _axis(model: Any, joint: int) -> Vector | None:
    """Axis of a revolute joint in its own frame, (3,); None for others."""
    kind = model.joints[joint]
    data = kind.createData()
    kind.calc(data, pinocchio.neutral(model)[kind.idx_q : kind.idx_q + kind.nq])
    S = np.array(data.S).reshape(6, -1)
    if S.shape[1] != 1 or np.linalg.norm(S[3:]) < 0.5:
        return None
    return np.array(S[3:, 0])
