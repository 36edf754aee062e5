"""Symmetric matrices in flat vectors: weights and gains of tasks."""

from __future__ import annotations

import casadi as ca
import numpy as np

from tsd_casadi.state import Matrix, Vector


def symmetric_matrix(lower_triangle: ca.SX, k: int) -> ca.SX:
    """Put a symmetric matrix together from its lower triangle, row by row.

    Args:
        lower_triangle: (k (k + 1) / 2,).
        k: Number of rows.

    Returns:
        (k, k).
    """
    matrix = ca.SX.zeros(k, k)
    for index, (row, column) in enumerate(zip(*np.tril_indices(k), strict=True)):
        matrix[int(row), int(column)] = lower_triangle[index]
        matrix[int(column), int(row)] = lower_triangle[index]
    return matrix


def coupled_matrix(diagonal: ca.SX, coupling: ca.SX) -> ca.SX:
    """Put a symmetric matrix together from its diagonal and what is below it, row by row.

    Args:
        diagonal: (k,).
        coupling: (k (k - 1) / 2,).

    Returns:
        (k, k).
    """
    matrix = ca.diag(diagonal)
    below = np.tril_indices(diagonal.numel(), -1)
    for index, (row, column) in enumerate(zip(*below, strict=True)):
        matrix[int(row), int(column)] = coupling[index]
        matrix[int(column), int(row)] = coupling[index]
    return matrix


def pack_lower_triangle(matrix: Matrix) -> Vector:
    """Take a symmetric matrix's lower triangle, row by row, as the command has a weight.

    Args:
        matrix: (k, k).

    Returns:
        (k (k + 1) / 2,).
    """
    return np.asarray(matrix[np.tril_indices(len(matrix))], dtype=float)


def pack_coupling(matrix: Matrix) -> Vector:
    """Take what is below a symmetric matrix's diagonal, as the command has a coupling.

    Args:
        matrix: (k, k).

    Returns:
        (k (k - 1) / 2,), row by row.
    """
    return np.asarray(matrix[np.tril_indices(len(matrix), -1)], dtype=float)
