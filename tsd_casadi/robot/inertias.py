"""Whether masses and inertias can be those of a body, and what to write where they cannot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tsd_casadi.state import Matrix, Vector

# by which the moments of a flat body may break the triangle inequality: descriptions
# are written with six digits
ROUNDING = 1e-5
# of what robots are made of on average, motors and air together [kg/m^3]
DENSITY = 1000.0
ENTRIES = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))


@dataclass(frozen=True)
class Written:
    """Mass and inertia as a description has them; Pinocchio's own type refuses some.

    Attributes:
        mass: [kg].
        lever: Centre of mass, (3,) [m].
        inertia: About it, (3, 3) [kg m^2].
    """

    mass: float
    lever: Vector
    inertia: Matrix


def written_inertia(link: ElementTree.Element) -> Written | None:
    """Read mass and inertia of a URDF's link; None where it has not both.

    Raises:
        ValueError: If one is not written as a number.
    """
    inertial = link.find("inertial")
    mass, moments = (
        None if inertial is None else inertial.find(tag) for tag in ("mass", "inertia")
    )
    if mass is None or moments is None:
        return None
    matrix = np.array([[float(moments.get(name, 0.0)) for name in row] for row in ENTRIES])
    return Written(float(mass.get("value", 0.0)), np.zeros(3), matrix)


def what_is_wrong(inertia: Any) -> str | None:
    """Tell why a body cannot have some mass and inertia.

    Args:
        inertia: ``pinocchio.Inertia``, or what is ``Written``.

    Returns:
        The reason, None if a body can have them; one without mass and inertia
        can, as the links between the axes of a joint with several.
    """
    mass, moments = float(inertia.mass), np.array(inertia.inertia)
    if not (
        math.isfinite(mass) and np.isfinite(moments).all() and np.isfinite(inertia.lever).all()
    ):
        return "its mass or inertia is not a number"
    if mass < 0:
        return f"its mass is negative, {mass:g} kg"
    principal = np.linalg.eigvalsh(moments)
    told = ", ".join(f"{value:.3g}" for value in principal)
    if mass == 0:
        return f"it has no mass but an inertia, {told} kg m^2" if principal.any() else None
    if principal[0] <= 0:
        return f"its inertia is not positive definite, the principal moments are {told} kg m^2"
    if principal[0] + principal[1] < (1 - ROUNDING) * principal[2]:
        return (
            f"its principal moments {told} kg m^2 break the triangle inequality, "
            "the largest is at most the sum of the others"
        )
    return None


def sphere_moment(mass: float) -> float:
    """Compute the moment of inertia of a solid sphere of usual density [kg m^2].

    What is least wrong where a description has a mass and no inertia: a limb's
    inertia about its joint is mostly that of its mass at its distance.

    Args:
        mass: [kg].
    """
    radius = float((3 * mass / (4 * math.pi * DENSITY)) ** (1 / 3))
    return 0.4 * mass * radius**2


def possible_moments(inertia: Any) -> tuple[float, float, float, float, float, float]:
    """Compute the moments of a body that are near to impossible ones.

    Args:
        inertia: ``pinocchio.Inertia``, or what is ``Written``.

    Returns:
        (xx, yy, zz, xy, xz, yz) about its centre of mass [kg m^2]: the same axes and
        the largest principal moment cut to the sum of the others, or those of a
        sphere where they are not positive.
    """
    moments = np.array(inertia.inertia)
    mass = float(inertia.mass)
    if not (mass > 0 and np.isfinite(moments).all() and np.linalg.eigvalsh(moments)[0] > 0):
        moment = sphere_moment(mass if math.isfinite(mass) and mass > 0 else 1.0)
        return (moment, moment, moment, 0.0, 0.0, 0.0)
    principal, axes = np.linalg.eigh(moments)
    principal[2] = min(principal[2], (1 - ROUNDING) * (principal[0] + principal[1]))
    J = axes @ np.diag(principal) @ axes.T
    return (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])


def override_lines(link: str, inertia: Any) -> str:
    """Write what to put into a robot file for a link that cannot be."""
    mass = "" if math.isfinite(inertia.mass) and inertia.mass > 0 else "mass: 1.0, "
    moments = ", ".join(f"{value:.6g}" for value in possible_moments(inertia))
    return f"links: {{{link}: {{{mass}inertia: [{moments}]}}}}"
