r"""How far a model's centre of mass may be off before anybody has measured anything.

With masses m_i, their sum m and centres p_i(q) of the links, independent relative
errors s_m of the masses and errors s_l of the centres along each axis,

.. math:: \mathrm{Var}[c] = \sum_i \Big( \frac{m_i}{m} \Big)^2
          \Big( s_m^2\, (p_i - c)^2 + s_l^2 \Big),

axis by axis, to first order. What the controller tracks is its own centre of
mass: no error that it sees tells of this one, and learning does not take it away.
"""

from __future__ import annotations

import numpy as np
import pinocchio

from tsd_casadi.center_of_mass.mass_prior import MassPrior
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector

UNMEASURED = MassPrior()


def prior_deviation(robot: Robot, q: Vector, prior: MassPrior = UNMEASURED) -> Vector:
    """Compute the standard deviation of the true centre of mass, (3,) [m], world axes.

    Args:
        q: Configuration, (nq,).
        prior: How far links may be off. Nobody has weighed the robot, either; see
            ``fit`` for what a measured weight and poses leave of it.
    """
    model, data = robot.model, robot.model.createData()
    pinocchio.forwardKinematics(model, data, q)
    inertias, places = list(model.inertias)[1:], list(data.oMi)[1:]
    shares = np.array([inertia.mass for inertia in inertias])
    shares /= shares.sum()
    centers = np.array(
        [place.act(inertia.lever) for place, inertia in zip(places, inertias, strict=True)]
    )
    from_mass = prior.mass * (centers - shares @ centers)
    variances = shares[:, None] ** 2 * (from_mass**2 + prior.center**2)
    return np.asarray(np.sqrt(variances.sum(axis=0)))
