"""Inertias for links whose own no body can have."""

from __future__ import annotations

from typing import Any

import numpy as np

from tsd_casadi.robot.inertias import possible_moments, sphere_moment, what_is_wrong
from tsd_casadi.robot.rigid_body_model import RigidBodyModel

Moments = dict[str, tuple[float, float, float, float, float, float]]

# moments this much smaller than those of a ball of the same mass are rounding, not steel
NOTHING = 1e-3


def mend_inertias(bodies: RigidBodyModel) -> Moments:
    """Find possible moments for what cannot be.

    Returns:
        (xx, yy, zz, xy, xz, yz) about the centre of mass, axes of the link [kg m^2], by
        the link that the joint of an impossible body moves.
    """
    inertias = enumerate(list(bodies.model.inertias)[1:], start=1)
    return {
        bodies.link_of(joint): _moments(inertia)
        for joint, inertia in inertias
        if inertia.mass > 0 and what_is_wrong(inertia) is not None
    }


def _moments(inertia: Any) -> tuple[float, float, float, float, float, float]:
    ball = sphere_moment(float(inertia.mass))
    if np.linalg.eigvalsh(np.array(inertia.inertia))[-1] < NOTHING * ball:
        return (ball, ball, ball, 0.0, 0.0, 0.0)
    return possible_moments(inertia)
