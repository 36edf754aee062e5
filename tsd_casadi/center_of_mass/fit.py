r"""Correcting the centre of mass from centres of pressure of static poses.

A robot at rest has its centre of mass straight above the centre of pressure.
With the chain of ``static_chain`` each pose k gives two linear equations

.. math:: y_k = F_{xy}(q_k)\, r + \nu_k, \qquad y_k = p_{cop,k} - p_{base,xy}(q_k), \qquad
          \nu_k \sim N(0, \sigma^2 I)

The height is in none of them, and becomes observable since links lean
differently from pose to pose. Few poses cannot tell all r_i: the prior is the
robot's own model with link masses uncertain by a fraction s_m of themselves,
given their measured sum m, and links' centres of mass uncertain by s_l:

.. math:: \bar m_i = m_i + \frac{m_i^2}{\sum m_j^2} \Big( m - \sum m_j \Big), \qquad
          \Sigma_m = s_m^2 \Big( \mathrm{diag}(m_i^2) - \frac{m^2 m^{2T}}{\sum m_j^2} \Big), \qquad
          \bar r = T \bar m / m, \quad
          \Sigma = \big( T \Sigma_m T^T + s_l^2\, \mathrm{diag}(m_i^2) \big) / m^2

with T from link masses to m r. Mean and covariance of r given y are those of
Bayesian linear regression (Rasmussen and Williams, Gaussian Processes for
Machine Learning, 2006, section 2.1), a ridge regression about the model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.center_of_mass.mass_prior import NOISE, MassPrior
from tsd_casadi.center_of_mass.static_chain import StaticChain
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector


@dataclass(frozen=True)
class StaticPose:
    """What is measured of a robot at rest.

    Attributes:
        q: Configuration as measured, (nq,).
        center_of_pressure: On the ground, (2,) [m], world frame.
        weight: Total vertical force of the ground [N].
    """

    q: Vector
    center_of_pressure: Vector
    weight: float


def prior_correction(
    robot: Robot, weight: float | None = None, prior: MassPrior | None = None
) -> CenterOfMassCorrection:
    """Tell what is known of the centre of mass before any pose is measured.

    Args:
        weight: As measured [N]; by default the model's.

    Raises:
        InvalidValue: If the weight is not positive.
    """
    prior = prior or MassPrior()
    chain = StaticChain(robot)
    masses, T = chain.masses, chain.moments()
    total = masses.sum() * (1.0 if weight is None else weight / robot.weight)
    if not 0 < total < np.inf:
        raise InvalidValue("weight", weight, "a positive force in N")
    squares = masses**2
    mean = masses + squares / squares.sum() * (total - masses.sum())
    spread = prior.mass**2 * (np.diag(squares) - np.outer(squares, squares) / squares.sum())
    centers = prior.center**2 * np.diag(np.repeat(squares, 3))
    covariance = (T @ spread @ T.T + centers) / total**2
    return CenterOfMassCorrection(robot, (T @ mean / total).reshape(-1, 3), covariance)


def fit_correction(
    robot: Robot,
    poses: Sequence[StaticPose],
    *,
    noise: float = NOISE,
    prior: MassPrior | None = None,
) -> CenterOfMassCorrection:
    """Correct a robot's centre of mass from static poses.

    Args:
        poses: Measurements; ten that lean differently do most of it.
        noise: sigma, of a pose's centre of pressure along each axis [m].

    Returns:
        The correction with its posterior covariance.

    Raises:
        InvalidValue: If there is no pose, or a number in one is none.
    """
    if not 0 < noise < np.inf:
        raise InvalidValue("noise", noise, "a positive standard deviation in m")
    if not poses:
        raise InvalidValue("poses", "empty", "at least one")
    for index, pose in enumerate(poses):
        for name, value, size in (
            ("q", pose.q, robot.nq),
            ("center_of_pressure", pose.center_of_pressure, 2),
            ("weight", [pose.weight], 1),
        ):
            if np.shape(value) != (size,) or not np.isfinite(value).all():
                raise InvalidValue(f"poses[{index}].{name}", value, f"numbers, shape ({size},)")
    known = prior_correction(robot, float(np.mean([pose.weight for pose in poses])), prior)
    chain = StaticChain(robot)
    F = np.vstack([chain.features(pose.q)[:2] for pose in poses])
    residual = np.concatenate(
        [pose.center_of_pressure - known.center_of_mass(pose.q)[:2] for pose in poses]
    )
    # in the space of the measurements: the prior's covariance has no inverse
    gain_T = np.linalg.solve(
        F @ known.covariance @ F.T + noise**2 * np.eye(len(F)), F @ known.covariance
    )
    terms = known.terms + (residual @ gain_T).reshape(-1, 3)
    covariance = known.covariance - known.covariance @ F.T @ gain_T
    return CenterOfMassCorrection(robot, terms, (covariance + covariance.T) / 2)
