"""Rotations as CasADi expressions: quaternion, matrix, rotation vector."""

from __future__ import annotations

import casadi as ca


def rotation_matrix(quaternion: ca.SX) -> ca.SX:
    """Convert a quaternion xyzw, normalised first, to a rotation matrix.

    Args:
        quaternion: (4,).

    Returns:
        (3, 3).
    """
    unit = quaternion / ca.norm_2(quaternion)
    x = ca.skew(unit[:3])
    return ca.SX.eye(3) + 2 * unit[3] * x + 2 * x @ x


def rotation_vector(R: ca.SX) -> ca.SX:
    r"""Compute a rotation's logarithm, :math:`\theta u` with :math:`0 \le \theta \le \pi`.

    Taken from the unit quaternion (x, w) as 2 atan2(\|x\|, w) x / \|x\|, which
    stays accurate up to half a turn.

    Args:
        R: (3, 3).

    Returns:
        (3,) [rad].
    """
    quaternion = _quaternion(R)
    x, w = quaternion[:3], quaternion[3]
    s = ca.norm_2(x)
    # theta / sin(theta / 2) tends to two; its series avoids 0 / 0
    small = s < 1e-6
    ratio = ca.if_else(small, 2 + s**2 / 3, 2 * ca.atan2(s, w) / ca.if_else(small, 1, s))
    return ratio * x


def _quaternion(R: ca.SX) -> ca.SX:
    """Convert a rotation to a unit quaternion xyzw, w >= 0, by its largest component."""
    diagonal = [R[i, i] for i in range(3)]
    squares = [1 + sum(diagonal)]
    squares += [1 + 2 * d - sum(diagonal) for d in diagonal]
    skew = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    xy, xz, yz = R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1]
    candidates = [
        ca.vertcat(*skew, squares[0]),
        ca.vertcat(squares[1], xy, xz, skew[0]),
        ca.vertcat(xy, squares[2], yz, skew[1]),
        ca.vertcat(xz, yz, squares[3], skew[2]),
    ]
    largest, chosen = squares[0], candidates[0]
    for square, candidate in zip(squares[1:], candidates[1:], strict=True):
        chosen = ca.if_else(square > largest, candidate, chosen)
        largest = ca.fmax(square, largest)
    return ca.if_else(chosen[3] < 0, -1, 1) * chosen / ca.norm_2(chosen)
