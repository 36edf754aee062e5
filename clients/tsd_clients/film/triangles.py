"""The triangles of a loaded mesh, with those mended that its loader mixes up."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.state import Matrix

Faces = NDArray[np.int64]

# twice the area below which a triangle is a line [m^2]
LEAST_AREA = 1e-12


def triangles(mesh: Any) -> tuple[Matrix, Faces]:
    """Read a mesh.

    Args:
        mesh: ``coal.BVHModelBase``.

    Returns:
        Vertices, (k, 3) [m], and the vertices of each triangle that is more than a
        line, (m, 3); no triangle where those of the mesh cannot be told.
    """
    vertices = np.asarray(mesh.vertices(), dtype=float)
    read = (mesh.tri_indices(index) for index in range(mesh.num_tris))
    faces = _mended(
        np.array([(face[0], face[1], face[2]) for face in read], dtype=np.int64).reshape(-1, 3),
        len(vertices),
    )
    first, second, third = (vertices[faces[:, corner]] for corner in range(3))
    area = np.linalg.norm(np.cross(second - first, third - first), axis=1)
    return vertices, faces[area > LEAST_AREA]


def _mended(faces: Faces, count: int) -> Faces:
    """Count vertices on from one material's part to the next.

    coal's loader (3.0.3) begins at zero again for each material of a mesh, so that the
    last vertices are in no triangle. A part begins with the triangle 0 1 2, since
    vertices are numbered as they are first met.

    Args:
        faces: (m, 3).
        count: Number of vertices.
    """
    if not len(faces) or faces.max() + 1 == count:
        return faces
    begins = np.flatnonzero((faces == [0, 1, 2]).all(axis=1))
    parts = np.split(faces, begins[1:])
    sizes = [int(part.max()) + 1 for part in parts]
    if sum(sizes) != count:
        return faces[:0]
    offsets = np.cumsum([0, *sizes[:-1]])
    return np.vstack([part + offset for part, offset in zip(parts, offsets, strict=True)])
