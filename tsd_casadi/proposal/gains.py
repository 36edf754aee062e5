"""Gains and weights, those of an adult humanoid scaled to another mass and size.

Tasks and posture are in accelerations, which are the same for a robot of any mass:
their gains and weights stay. Forces grow with the weight, moments with weight times
height, joint damping with mass times height squared and the root of gravity over height.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tsd_casadi.proposal.body import Body
from tsd_casadi.proposal.home_posture import HomePosture

# of the paper's robot: mass [kg], height of its centre of mass at home [m]
MASS, HEIGHT = 57.33, 0.781
# torsional friction in shares of a sole's smaller side, as there: it acts within the sole
TORSION = 0.5


@dataclass(frozen=True)
class Gains:
    """What depends on a robot's size.

    Attributes:
        force: Weight of contact forces [1/N^2].
        moment: Weight of contact moments [1/(N m)^2].
        acceleration: Bound of joint accelerations [rad/s^2].
        damping: Of the safe torque [N m s/rad].
        minimum_force: Of each foot [N].
        torsional_friction: Of each sole [m].
    """

    force: float
    moment: float
    acceleration: float
    damping: float
    minimum_force: float
    torsional_friction: float


def scale_gains(body: Body, home: HomePosture) -> Gains:
    """Scale the gains to a robot, two digits each."""
    mass, height = body.mass / MASS, home.posed.height / HEIGHT
    narrow = min(float(np.ptp(side)) for sole in body.soles for side in (sole.x, sole.y))
    return Gains(
        force=_two_digits(1e-6 / mass**2),
        moment=_two_digits(1e-5 / (mass * height) ** 2),
        # swinging under gravity is faster the smaller a robot is
        acceleration=_two_digits(500.0 / height),
        damping=_two_digits(5.0 * mass * height**1.5),
        minimum_force=_two_digits(5.0 * mass),
        torsional_friction=_two_digits(TORSION * narrow),
    )


def _two_digits(value: float) -> float:
    digits = 1 - math.floor(math.log10(value))
    return round(value, digits)
