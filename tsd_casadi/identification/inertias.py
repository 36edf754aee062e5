r"""Inertial parameters from motion data, the model-based alternative to learning.

The equations are those of ``regressor``; what the data leave open stays as in the
nominal model, see ``physical_consistency``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.identification.observations import Friction, Observations
from tsd_casadi.identification.physical_consistency import (
    PARAMETERS,
    Block,
    body,
    fit_consistent,
    pseudo_inertia,
    scalar,
)
from tsd_casadi.identification.regressor import friction_rows, inertial_rows, nominal_parameters
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector

# sigma [N m]: more than the residuals, which are friction and lag and no white
# noise; chosen with the simulated hardware, where a tenth of it turns friction
# into absurd inertias if friction is left out
TORQUE_NOISE = 10.0
CLOSENESS = 10.0  # gamma of the links: some 16 % of their masses
# nothing is known of friction but its order of magnitude
NOMINAL_FRICTION = 1.0  # N m s/rad and N m
# gamma of its coefficients: so small that no friction is found where there is
# none, chosen with a frictionless simulation
FRICTION_CLOSENESS = 1e-5


@dataclass(frozen=True)
class Identified:
    """A model that explains observations.

    Attributes:
        inertias: ``pinocchio.Inertia`` of each joint's body, base first.
        friction: Of the joints, zero where it was left out.
        residual: RMS of what is left of each row [N m].
        nominal_residual: The same for the nominal model without friction.
    """

    inertias: tuple[Any, ...]
    friction: Friction
    residual: float
    nominal_residual: float


def identify_inertias(
    robot: Robot, observed: Observations, closeness: float = CLOSENESS
) -> Identified:
    """Find the rigid bodies that explain what was observed.

    Args:
        closeness: gamma, how much the nominal model is trusted.

    Returns:
        The identified model, without friction.

    Raises:
        InvalidValue: If there is nothing to identify from, a number is not
            finite, closeness not positive, or a link of the nominal model no
            body that can be.
    """
    _check(robot, observed, closeness)
    A, b = inertial_rows(robot, observed)
    return _identify(robot, A, b, closeness)


def identify_with_friction(
    robot: Robot, observed: Observations, closeness: float = CLOSENESS
) -> Identified:
    """Find the rigid bodies and the joint friction that explain what was observed.

    Args:
        closeness: gamma, how much the nominal model is trusted.

    Returns:
        The identified model.

    Raises:
        InvalidValue: If there is nothing to identify from, a number is not
            finite, closeness not positive, or a link of the nominal model no
            body that can be.
    """
    _check(robot, observed, closeness)
    A, b = inertial_rows(robot, observed)
    return _identify(robot, np.hstack((A, friction_rows(robot, observed))), b, closeness)


def _check(robot: Robot, observed: Observations, closeness: float) -> None:
    widths = {"q": robot.nq, "v": robot.nv, "a": robot.nv, "tau": robot.n}
    samples = len(observed.q)
    for name, values in vars(observed).items():
        expected = (samples, widths[name])
        if samples == 0 or values.shape != expected:
            raise InvalidValue(
                f"observed {name}", f"of shape {values.shape}", f"shape (N, {widths[name]}), N > 0"
            )
        if not np.isfinite(values).all():
            raise InvalidValue(f"observed {name}", "not finite", "finite numbers")
    for name, inertia in zip(
        ("base", *robot.joint_names), list(robot.model.inertias)[1:], strict=True
    ):
        # pseudo-inertia: mass and second moments of a body of positive density
        if np.linalg.eigvalsh(pseudo_inertia(inertia.toDynamicParameters())).min() <= 0:
            raise InvalidValue(
                f"the link at {name}",
                f"mass {inertia.mass:g} kg with such an inertia",
                "a mass and moments of inertia that a body of positive density can have",
            )
    if not 0 < closeness < np.inf:
        raise InvalidValue("closeness", closeness, "a positive number")


def _identify(robot: Robot, A: Matrix, b: Vector, closeness: float) -> Identified:
    nominal = nominal_parameters(robot)
    links = len(nominal) // PARAMETERS
    coefficients = A.shape[1] - len(nominal)
    prior = np.concatenate((nominal, np.full(coefficients, NOMINAL_FRICTION)))
    blocks: list[Block] = [body(PARAMETERS * i, closeness) for i in range(links)]
    blocks += [scalar(len(nominal) + i, FRICTION_CLOSENESS) for i in range(coefficients)]
    x = fit_consistent(A / TORQUE_NOISE, b / TORQUE_NOISE, prior, blocks)
    parts = x[: len(nominal)].reshape(links, PARAMETERS)
    friction = np.zeros(2 * robot.n)
    friction[:coefficients] = x[len(nominal) :]
    return Identified(
        inertias=tuple(pinocchio.Inertia.FromDynamicParameters(part) for part in parts),
        friction=Friction(friction[: robot.n], friction[robot.n :]),
        residual=_rms(A @ x - b),
        nominal_residual=_rms(A[:, : len(nominal)] @ nominal - b),
    )


def _rms(values: Vector) -> float:
    return float(np.sqrt(np.mean(values**2)))
