from __future__ import annotations

import numpy as np

from tsd_clients.film.decimate import decimate


def _sphere(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """A unit sphere as an STL file has it: three vertices of its own for each triangle."""
    polar, around = np.meshgrid(
        np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1), indexing="ij"
    )
    points = np.stack(
        (np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)), axis=-1
    )
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    corners = np.concatenate(
        [np.stack(part, axis=2).reshape(-1, 3) for part in ((a, b, c), (a, c, d))]
    )
    return corners, np.arange(len(corners)).reshape(-1, 3)


def test_a_large_mesh_keeps_its_shape_with_fewer_triangles() -> None:
    vertices, faces = _sphere(30)
    assert len(faces) == 3600
    fewer, left = decimate(vertices, faces, 400)
    assert 200 < len(left) <= 400
    assert np.abs(np.linalg.norm(fewer, axis=1) - 1).max() < 0.05
    corners = fewer[left]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert abs(abs(volume) - 4 / 3 * np.pi) < 0.2


def test_a_small_mesh_is_left_alone() -> None:
    vertices, faces = _sphere(3)
    assert decimate(vertices, faces, 1000)[1] is faces
