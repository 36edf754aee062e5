from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from tsd_casadi import Robot, load_robot
from tsd_casadi.robot.checks import FLATNESS
from tsd_casadi.robot.robot_file_sections import SoleFile
from tsd_clients.simulator.build_scene import build_scene
from tsd_clients.simulator.undersides import find_undersides, sole_extents

# where L_sole is in L_foot [m]
SOLE = np.array([0.04, 0.0, -0.064])
WithFoot = Callable[..., Robot]


@pytest.fixture
def with_foot(write_robot: Callable[..., Path]) -> WithFoot:
    """The robot without a scene, its left foot with some collision shapes."""

    def load(*shapes: str) -> Robot:
        written = "".join(f"<collision>{shape}</collision>" for shape in shapes)
        link = '<link name="L_foot">'
        return load_robot(
            write_robot(
                lambda document: document.pop("scene"),
                lambda text: text.replace(link, f"{link}{written}"),
            )
        )

    return load


def shape(kind: str, at: str, rpy: str = "0 0 0") -> str:
    xyz = " ".join(map(str, SOLE + [float(x) for x in at.split()]))
    return f'<origin xyz="{xyz}" rpy="{rpy}"/><geometry><{kind}/></geometry>'


def extents(robot: Robot) -> tuple[tuple[float, float], tuple[float, float]]:
    contact = robot.description.contacts[0]
    assert isinstance(contact, SoleFile)
    return sole_extents(contact, find_undersides(robot)["left_foot"])


FEET = {
    "a box": ([shape('box size="0.25 0.12 0.04"', "0.005 0 0.02")], (-0.12, 0.13), (-0.06, 0.06)),
    "balls at its corners": (
        [
            shape('sphere radius="0.01"', f"{x} {y} 0.01")
            for x in (-0.11, 0.14)
            for y in (-0.07, 0.07)
        ],
        (-0.11, 0.14),
        (-0.07, 0.07),
    ),
    "two boxes": (
        [
            shape('box size="0.1 0.12 0.04"', "-0.08 0 0.02"),
            shape('box size="0.1 0.12 0.04"', "0.08 0 0.02"),
        ],
        (-0.13, 0.13),
        (-0.06, 0.06),
    ),
    "a heel above the ground": (
        [
            shape('box size="0.22 0.12 0.04"', "0 0 0.02"),
            shape('box size="0.5 0.12 0.04"', "0 0 0.03"),
        ],
        (-0.11, 0.11),
        (-0.06, 0.06),
    ),
    "less than the controller counts on": (
        [shape('box size="0.15 0.05 0.04"', "0 0 0.02")],
        (-0.10, 0.10),
        (-0.05, 0.05),
    ),
    "nothing": ([], (-0.10, 0.10), (-0.05, 0.05)),
    "a mesh": ([shape('mesh filename="gone.stl"', "0 0 0")], (-0.10, 0.10), (-0.05, 0.05)),
}


@pytest.mark.parametrize("what", FEET)
def test_a_sole_is_as_large_as_its_foot_is_flat(with_foot: WithFoot, what: str) -> None:
    shapes, x, y = FEET[what]
    robot = with_foot(*shapes)
    np.testing.assert_allclose(extents(robot), [x, y], atol=1e-9)
    geom = build_scene(robot).compile().geom("left_foot")
    np.testing.assert_allclose(2 * geom.size[:2], [np.ptp(x), np.ptp(y)], atol=1e-9)


def test_a_round_foot_keeps_its_corners_on_it(with_foot: WithFoot) -> None:
    robot = with_foot(shape('cylinder radius="0.15" length="0.04"', "0 0 0.02"))
    (x, X), (y, Y) = extents(robot)
    for corner in ((x, y), (x, Y), (X, y), (X, Y)):
        assert np.hypot(*corner) == pytest.approx(0.15, abs=1e-3)
    assert pytest.approx(np.sqrt(0.15**2 - 0.05**2), abs=1e-3) == X


@pytest.mark.parametrize(("share", "counts"), [(0.9, True), (1.1, False)])
def test_a_foot_that_is_not_at_the_contact_does_not_count(
    with_foot: WithFoot, share: float, counts: bool
) -> None:
    height = 0.02 + share * FLATNESS
    robot = with_foot(shape('box size="0.25 0.12 0.04"', f"0 0 {height}"))
    assert (extents(robot)[0][1] > 0.11) == counts


# metres within a foot
PLACES = st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))


@hypothesis.given(st.lists(PLACES, min_size=4, max_size=12))
def test_a_sole_stays_on_its_foot_and_holds_the_controllers(
    robot: Robot, points: list[tuple[float, float]]
) -> None:
    contact = robot.description.contacts[0]
    assert isinstance(contact, SoleFile)
    corners = [(x, y) for x in contact.x for y in contact.y]
    underside = np.array([*points, *corners])
    (x, X), (y, Y) = sole_extents(contact, underside)
    assert x <= contact.x[0] < contact.x[1] <= X
    assert y <= contact.y[0] < contact.y[1] <= Y
    hull = Delaunay(underside, qhull_options="QJ")
    middle = underside.mean(axis=0)
    for corner in ((x, y), (x, Y), (X, y), (X, Y)):
        # a degree between directions leaves less than a tenth of a millimetre
        inside = middle + (np.array(corner) - middle) * (1 - 1e-3)
        assert hull.find_simplex(inside) >= 0
