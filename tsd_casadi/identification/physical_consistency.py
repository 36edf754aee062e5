r"""Least squares among bodies that can exist, near to a nominal model.

Motion data do not show every parameter :math:`x`, so the model is kept as near
to the nominal one as they allow,

.. math::

    \min \; \frac{1}{2} \|A x - b\|^2 + \sum_k \gamma_k \Big(
        \mathrm{tr}(\bar P_k^{-1} P_k) - \log \det (\bar P_k^{-1} P_k) - \dim P_k \Big),

with :math:`P_k` the 4 x 4 pseudo-inertia of link k and :math:`\bar P_k` its
nominal value: the entropic divergence of Lee, Wensing and Park, "Geometric Robot
Dynamic Identification: A Convex Programming Approach" (2020). It is convex, does
not depend on the links' frames, and infinite where a body stops being physically
possible. A positive number, such as a friction coefficient, counts as a 1 x 1
matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tsd_casadi.state import Matrix, Vector

PARAMETERS = 10  # of a link: mass, first moments, inertia about the frame's origin
STEPS = 200
DECREMENT = 1e-10  # Newton's, of the cost
SHORTEST = 1e-10  # share of a Newton step
# least eigenvalue of P next to its nominal value: no body is thinner than that
THINNEST = 1e-9
RIDGE = 1e-14  # of the scaled Hessian, against rounding


def pseudo_inertia(parameters: Vector) -> Matrix:
    r"""Compute P of a link, positive definite exactly for bodies that can exist.

    .. math:: P = \int \begin{pmatrix} r \\ 1 \end{pmatrix}
        \begin{pmatrix} r \\ 1 \end{pmatrix}^T dm

    Args:
        parameters: Mass, first moments, then inertia xx xy yy xz yz zz about
            the frame's origin, (10,).

    Returns:
        (4, 4) [kg m^2, kg m, kg].
    """
    m, hx, hy, hz, xx, xy, yy, xz, yz, zz = parameters
    half = (xx + yy + zz) / 2
    return np.array(
        [
            [half - xx, -xy, -xz, hx],
            [-xy, half - yy, -yz, hy],
            [-xz, -yz, half - zz, hz],
            [hx, hy, hz, m],
        ]
    )


# P is linear in the parameters: its derivatives by each of them, (10, 4, 4)
_BASIS = np.array([pseudo_inertia(unit) for unit in np.eye(PARAMETERS)])


@dataclass(frozen=True)
class Block:
    """A matrix P that has to stay positive definite, and near to its nominal value.

    Attributes:
        part: Where its parameters lie in x.
        basis: Its derivatives by them, (parameters, size, size).
        gamma: How much the nominal value is trusted.
    """

    part: slice
    basis: Matrix
    gamma: float

    def matrix(self, x: Vector) -> Matrix:
        """Compute P at some parameters x."""
        return np.asarray(np.tensordot(x[self.part], self.basis, axes=1))


def body(start: int, gamma: float) -> Block:
    """Make the block of a rigid body whose ten parameters start somewhere in x.

    Args:
        start: Index of the first of them.
        gamma: How much its nominal inertia is trusted.
    """
    return Block(slice(start, start + PARAMETERS), _BASIS, gamma)


def scalar(place: int, gamma: float) -> Block:
    """Make the block of a positive number at some place of x.

    Args:
        gamma: How much its nominal value is trusted.
    """
    return Block(slice(place, place + 1), np.ones((1, 1, 1)), gamma)


def fit_consistent(A: Matrix, b: Vector, nominal: Vector, blocks: Sequence[Block]) -> Vector:
    """Minimise the cost by Newton's method, with steps short enough to keep it finite.

    Args:
        A: (rows, parameters), rows divided by their standard deviation.
        b: (rows,).
        nominal: Where to stay near to, every block positive definite.
        blocks: All of x, each parameter in one of them.

    Returns:
        x, (parameters,).
    """
    gram, projected = A.T @ A, A.T @ b
    # in coordinates where each nominal P is the identity
    bases = [_whitened(block, nominal) for block in blocks]

    def cost(x: Vector) -> float:
        total = float(x @ gram @ x / 2 - projected @ x)
        for block, basis in zip(blocks, bases, strict=True):
            C = np.tensordot(x[block.part], basis, axes=1)
            eigenvalues = np.linalg.eigvalsh(C)
            if eigenvalues[0] < THINNEST:
                return np.inf
            total += block.gamma * float(np.sum(eigenvalues - np.log(eigenvalues)))
        return total

    x, best = nominal.copy(), cost(nominal)
    for _ in range(STEPS):
        gradient, hessian = gram @ x - projected, gram.copy()
        for block, basis in zip(blocks, bases, strict=True):
            part, gamma = block.part, block.gamma
            C_inverse = np.linalg.inv(np.tensordot(x[part], basis, axes=1))
            slope = np.eye(len(C_inverse)) - C_inverse
            gradient[part] += gamma * np.tensordot(basis, slope, axes=2)
            turned = C_inverse @ basis
            hessian[part, part] += gamma * np.einsum("iab,jba->ij", turned, turned)
        # parameters differ in size by orders of magnitude
        scale = 1 / np.sqrt(np.diag(hessian))
        scaled = scale[:, None] * hessian * scale + RIDGE * np.eye(len(x))
        step = -scale * np.linalg.solve(scaled, scale * gradient)
        decrement = -float(gradient @ step)
        if decrement < DECREMENT:
            break
        length = 1.0
        while (there := cost(x + length * step)) > best - 1e-4 * length * decrement:
            length /= 2
            if length < SHORTEST:
                return x
        x, best = x + length * step, there
    return x


def _whitened(block: Block, nominal: Vector) -> Matrix:
    """Compute the derivatives of L^-1 P L^-T, where L L^T is the nominal P."""
    inverse = np.linalg.inv(np.linalg.cholesky(block.matrix(nominal)))
    return np.asarray(inverse @ block.basis @ inverse.T)
