"""How much room a posture leaves: to the joints' limits and to their torques."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio

from tsd_casadi.proposal.arms import sag
from tsd_casadi.proposal.body import Body
from tsd_casadi.proposal.inverse_statics import torque_shares
from tsd_casadi.state import Vector

# stiffness of tasks and posture in every proposed file [1/s^2], and the model error that a
# robot has to bear without leaving its range
P_COM, P_POSTURE, MODEL_ERROR = 50.0, 40.0, 0.1
# the centre of mass sags by what is missing of g: 20 mm at a stiffness of 50
SAG = MODEL_ERROR * 9.81 / P_COM
# every joint keeps this to its limits, knees stay bent by at least so much [rad]
LEAST_MARGIN, LEAST_BEND = 0.1, 0.6
# of angles that the solver holds at those bounds [rad]
TOLERANCE = 1e-4
# of a joint's torque, at the bottom of the slow motion: the rest is for 10 % more mass,
# for acceleration and for the feedback
LARGEST_SHARE = 0.8


@dataclass(frozen=True)
class Posed:
    """One posture of the family over the knees' bend.

    Attributes:
        q: Configuration, (nq,).
        bend: Of the knees [rad].
        height: Of the centre of mass above the soles [m].
        margin: Least distance of a joint to a limit, sag taken off [rad].
        share: Largest torque / limit.
    """

    q: Vector
    bend: float
    height: float
    margin: float
    share: float

    @property
    def is_good(self) -> bool:
        """Whether a motion may go through this posture."""
        return (
            self.bend >= LEAST_BEND - TOLERANCE
            and self.margin >= LEAST_MARGIN - TOLERANCE
            and self.share <= LARGEST_SHARE
        )


def pose(body: Body, q: Vector) -> Posed:
    """Measure a posture at rest."""
    model = body.model
    data = model.createData()
    com = pinocchio.centerOfMass(model, data, q)
    distance = np.minimum(q[7:] - body.low, body.high - q[7:])
    margin = float(np.min(distance - sag(body, q, MODEL_ERROR, P_POSTURE)))
    shares = torque_shares(body, q, np.zeros(model.nv))
    share = float("inf") if shares is None else float(shares.max())
    bend = min(leg.bend(model, q) for leg in body.legs)
    return Posed(q, bend, float(com[2]), margin, share)
