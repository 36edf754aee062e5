"""Fewer triangles for pictures that move."""

from __future__ import annotations

import numpy as np

from tsd_casadi.state import Matrix
from tsd_clients.film.triangles import Faces


def decimate(vertices: Matrix, faces: Faces, most: int) -> tuple[Matrix, Faces]:
    """Simplify a mesh by collapsing edges, the least visible ones first.

    Args:
        vertices: (k, 3) [m].
        faces: (m, 3).
        most: Number of faces that it may have, about.

    Returns:
        Vertices and faces; those given where there are few enough.
    """
    if len(faces) <= most:
        return vertices, faces
    import fast_simplification

    # STL files have three vertices for each triangle, and no edge to collapse
    joined, places = np.unique(vertices.astype(np.float32), axis=0, return_inverse=True)
    fewer, left = fast_simplification.simplify(
        joined, places.reshape(-1)[faces].astype(np.int32), target_count=most
    )
    return np.asarray(fewer, dtype=float), np.asarray(left, dtype=np.int64)
