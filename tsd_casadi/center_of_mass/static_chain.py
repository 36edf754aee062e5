r"""The centre of mass as the tip of a chain of constant vectors.

.. math:: c(q) = p_{base} + \sum_i R_i(q)\, r_i, \qquad
          m\, r_i = m_i l_i + \sum_{j \in children(i)} \Big( \sum_{k \succeq j} m_k \Big) t_j

with the link masses m_i, their sum m, each link's centre of mass l_i in its own
frame and the place t_j of joint j in its parent's frame: the statically
equivalent serial chain of Cotton, Murray and Fraisse (IEEE Transactions on
Robotics, 2009). All that masses and centres of mass can do to c is in the r_i.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector


class StaticChain:
    """A robot's chain; its links are the base and what each joint moves.

    Attributes:
        links: Names of the joints that carry the links, the base's first.
        masses: Of the links as the model has them, (N,) [kg].
        centers: Of mass, each in its link's frame, (N, 3) [m].
    """

    def __init__(self, robot: Robot) -> None:
        """Take a robot's links apart.

        Raises:
            InvalidValue: If it has a prismatic joint: its chain would not be
                one of constant vectors.
        """
        model = robot.model
        self._model, self._data = model, model.createData()
        for joint, name in zip(list(model.joints)[2:], robot.joint_names, strict=True):
            if not joint.shortname().startswith("JointModelR"):
                raise InvalidValue(f"joint {name}", joint.shortname(), "a revolute joint")
        inertias = list(model.inertias)[1:]
        self.links: tuple[str, ...] = tuple(list(model.names)[1:])
        self.masses: Vector = np.array([inertia.mass for inertia in inertias])
        self.centers: Matrix = np.array([inertia.lever for inertia in inertias])
        self._offsets = np.array([place.translation for place in list(model.jointPlacements)[1:]])
        parents = np.array(list(model.parents)[1:]) - 1
        self._parents = parents
        # above[i, j]: whether link j hangs on link i, itself included
        above = np.eye(len(parents), dtype=bool)
        for link in range(1, len(parents)):
            above[:, link] |= above[:, parents[link]]
        self._above = above

    def moments(self) -> Matrix:
        """Map link masses to the vectors, each times the total mass, (3 N, N) [m]."""
        count = len(self.links)
        moments = np.zeros((count, 3, count))
        moments[np.arange(count), :, np.arange(count)] = self.centers
        for link in range(1, count):
            moments[self._parents[link]] += np.outer(self._offsets[link], self._above[link])
        return moments.reshape(3 * count, count)

    def terms(self) -> Matrix:
        """Compute the model's own r_i, (N, 3) [m]."""
        vectors: Vector = self.moments() @ self.masses / self.masses.sum()
        return vectors.reshape(-1, 3)

    def features(self, q: Vector) -> Matrix:
        """Put the links' orientations side by side, so that c = p_base + features @ r.

        Args:
            q: Configuration, (nq,).

        Returns:
            Of shape (3, 3 N), world axes.
        """
        pinocchio.forwardKinematics(self._model, self._data, q)
        return np.hstack([placement.rotation for placement in list(self._data.oMi)[1:]])

    def model_with(self, terms: Matrix) -> Any:
        """Make a model with the same joints whose centre of mass follows the chain.

        Only its centre of mass means anything: the links weigh 1 kg each, and
        their centres make up for that.

        Args:
            terms: r_i, (N, 3) [m].

        Returns:
            ``pinocchio.Model``.
        """
        count = len(self.links)
        hung = self.moments() @ np.ones(count) - self.centers.ravel()
        centers = count * terms - hung.reshape(-1, 3)
        model = pinocchio.Model(self._model)
        for link, center in enumerate(centers):
            model.inertias[link + 1] = pinocchio.Inertia(1.0, center, np.zeros((3, 3)))
        return model
