"""What robots look like on the page: few triangles, in the right places."""

from __future__ import annotations

import coal
import numpy as np
import pytest

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix
from tsd_clients.film.triangles import Faces
from tsd_clients.viewer import primitives
from tsd_clients.viewer.robot_shapes import BUDGET, Shape, _decimated, _joined, robot_shapes
from tsd_clients.viewer.shape_cache import read_shapes, write_shapes


def volume(vertices: Matrix, faces: Faces) -> float:
    """Of a closed surface whose triangles turn anticlockwise as seen from outside."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


# coal computes volumes of its own; of round bodies 20 sides have some percent less
@pytest.mark.parametrize(
    ("made", "exact", "share"),
    [
        (primitives.box(np.array([0.1, 0.2, 0.3])), coal.Box(0.2, 0.4, 0.6), 1e-12),
        (primitives.ellipsoid(np.full(3, 0.2)), coal.Sphere(0.2), 0.06),
        (primitives.ellipsoid(np.array([0.1, 0.2, 0.3])), coal.Ellipsoid(0.1, 0.2, 0.3), 0.06),
        (primitives.cylinder(0.1, 0.2), coal.Cylinder(0.1, 0.4), 0.03),
        (primitives.capsule(0.1, 0.2), coal.Capsule(0.1, 0.4), 0.06),
        (primitives.stick(np.array([0.0, 0.3, 0.4]), 0.05), coal.Capsule(0.05, 0.5), 0.06),
    ],
)
def test_primitives_are_closed_and_turned_outwards(
    made: tuple[Matrix, Faces], exact: coal.ShapeBase, share: float
) -> None:
    assert volume(*made) == pytest.approx(exact.computeVolume(), rel=share)


def test_a_stick_ends_where_the_link_does() -> None:
    end = np.array([0.1, -0.2, 0.25])
    vertices, _ = primitives.stick(end, 0.02)
    along = vertices @ end / np.linalg.norm(end)
    assert along.min() == pytest.approx(-0.02)
    assert along.max() == pytest.approx(np.linalg.norm(end) + 0.02)


def test_every_robot_has_a_shape_that_stands_on_the_ground(any_robot: Robot) -> None:
    import pinocchio

    shapes = robot_shapes(any_robot)
    data = any_robot.model.createData()
    pinocchio.forwardKinematics(any_robot.model, data, any_robot.home.q)
    lowest = min(
        (data.oMi[shape.joint].rotation @ shape.vertices.T).T[:, 2].min()
        + data.oMi[shape.joint].translation[2]
        for shape in shapes
    )
    # soles are thick, and some meshes are a bit longer than the foot they show
    assert lowest == pytest.approx(0.0, abs=0.03)
    assert sum(len(shape.faces) for shape in shapes) < 1.1 * BUDGET
    assert len({(shape.joint, shape.color) for shape in shapes}) == len(shapes)


def test_a_fine_mesh_becomes_coarse_and_stays_where_it_was() -> None:
    turn = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    height = np.linspace(-0.1, 0.1, 100)
    vertices = np.array([(0.1 * np.cos(t), 0.1 * np.sin(t), z) for z in height for t in turn])
    ring, side = np.divmod(np.arange(99 * 200), 200)
    a, b = ring * 200 + side, ring * 200 + (side + 1) % 200
    faces = np.vstack((np.column_stack((a, b, b + 200)), np.column_stack((a, b + 200, a + 200))))
    coarse = _decimated(Shape(1, vertices, faces, (0.5, 0.5, 0.5)), 0.01)
    assert len(coarse.faces) <= 0.015 * len(faces)
    assert np.allclose(np.linalg.norm(coarse.vertices[:, :2], axis=1), 0.1, atol=0.01)


def test_shapes_of_a_joint_and_colour_are_one() -> None:
    box = primitives.box(np.ones(3))
    gray, red = (0.5, 0.5, 0.5), (1.0, 0.0, 0.0)
    joined = _joined([Shape(1, *box, gray), Shape(2, *box, gray), Shape(1, *box, gray)])
    assert [(shape.joint, len(shape.faces)) for shape in joined] == [(1, 24), (2, 12)]
    assert len(_joined([Shape(1, *box, gray), Shape(1, *box, red)])) == 2
    assert volume(joined[0].vertices, joined[0].faces) == pytest.approx(16.0)


def test_kept_shapes_are_read_back(robot: Robot, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("cache") / "shapes" / "robot.npz"
    made = robot_shapes(robot)
    write_shapes(made, path)
    read = read_shapes(path)
    assert [(s.joint, s.color) for s in read] == [(s.joint, s.color) for s in made]
    for one, other in zip(read, made, strict=True):
        assert np.allclose(one.vertices, other.vertices, atol=1e-6)
        assert np.array_equal(one.faces, other.faces)
