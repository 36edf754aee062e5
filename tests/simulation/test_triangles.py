from __future__ import annotations

from pathlib import Path
from typing import Any

import coal
import numpy as np
import pytest

from tsd_clients.film.triangles import LEAST_AREA, triangles

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)


class Loaded:
    """A mesh as its loader hands it over."""

    def __init__(self, vertices: Any, faces: Any) -> None:
        self._vertices, self._faces = np.asarray(vertices, dtype=float), faces
        self.num_tris = len(faces)

    def vertices(self) -> Any:
        return self._vertices

    def tri_indices(self, index: int) -> Any:
        return self._faces[index]


def test_a_mesh_is_read_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "solid.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    vertices, faces = triangles(coal.MeshLoader().load(str(path), np.ones(3)))
    corners = vertices[faces]
    # the volume under its faces: 1 * 2 * 3 / 6
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(1.0)


def test_parts_that_all_count_from_zero_are_told_apart() -> None:
    faces = [[0, 1, 2], [1, 2, 3], [0, 1, 2], [0, 2, 3], [0, 1, 2]]
    vertices = np.vstack([CORNERS, CORNERS + 5, CORNERS[:3] + 9])
    _, mended = triangles(Loaded(vertices, faces))
    assert mended.tolist() == [[0, 1, 2], [1, 2, 3], [4, 5, 6], [4, 6, 7], [8, 9, 10]]


def test_faces_that_cannot_be_told_are_left_out() -> None:
    vertices, faces = triangles(Loaded(np.vstack([CORNERS, CORNERS]), [[0, 1, 2], [1, 2, 3]]))
    assert len(vertices) == 8
    assert faces.shape == (0, 3)


def test_a_mesh_without_faces_stays_one() -> None:
    assert triangles(Loaded(CORNERS, []))[1].shape == (0, 3)


@pytest.mark.parametrize(("share", "kept"), [(0.9, 0), (1.1, 1)])
def test_lines_are_no_triangles(share: float, kept: int) -> None:
    vertices = [[0, 0, 0], [1, 0, 0], [0, share * LEAST_AREA, 0]]
    assert len(triangles(Loaded(vertices, [[0, 1, 2]]))[1]) == kept
