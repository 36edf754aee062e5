"""What a robot can do of a motion."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tsd_casadi import Robot, Squat, load_robot
from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_casadi.motions.lean import Lean
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.ranges import check_motion, range_of, usual_of
from tsd_casadi.motions.sway import Sway
from tsd_casadi.motions.twist import Twist
from tsd_casadi.robot.reaching import reach
from tsd_casadi.robot.standing import stand
from tsd_casadi.robot.support_polygon import margin, support_polygon


def range_by_name(robot: Robot, kind: type[Motion], name: str) -> tuple[float, float]:
    item = next(item for item in kind.declaration().parameters if item.name == name)
    return range_of(robot, kind, item)


@pytest.fixture
def free(write_robot: Callable[..., Path]) -> Robot:
    """The shipped robot, of which nobody says what it can do."""
    return load_robot(write_robot(lambda document: document.pop("motions")))


def test_the_file_narrows(robot: Robot) -> None:
    assert range_by_name(robot, Squat, "amplitude") == (0.001, 0.08)
    assert range_by_name(robot, Squat, "height") == (-0.05, 0.06)
    assert range_by_name(robot, Squat, "frequency") == (0.05, 1.0)


def test_without_the_file_it_is_what_can_be_reached(free: Robot) -> None:
    low, high = range_by_name(free, Squat, "amplitude")
    assert low == 0.0
    for sign in (-1, 1):
        assert reach(free, free.home, {"com.z": sign * high}) is not None
    # not by far more: the knees are straight
    assert reach(free, free.home, {"com.z": 2 * high}) is None
    low, high = range_by_name(free, Squat, "height")
    assert low < -0.05 < 0.05 < high
    for height in (low, high):
        stand(free, height)
    with pytest.raises(InvalidValue, match="can stand at"):
        stand(free, 2 * high)


def test_what_is_in_every_range_may_be_too_far_together(free: Robot) -> None:
    high = range_by_name(free, Squat, "amplitude")[1], range_by_name(free, Squat, "height")[1]
    check_motion(free, Squat(high[0]))
    check_motion(free, Squat(0.01, 0.25, high[1]))
    with pytest.raises(InvalidValue, match=r"squat is amplitude .*together they go too far"):
        check_motion(free, Squat(high[0], 0.25, high[1]))


@pytest.mark.parametrize(("kind", "axis"), [(Sway, 1), (Lean, 0)])
def test_the_centre_of_mass_stays_over_the_soles(
    robot: Robot, kind: type[Motion], axis: int
) -> None:
    _, high = range_by_name(robot, kind, "amplitude")
    polygon = support_polygon(robot, robot.home.q)
    for sign in (-1, 1):
        place = robot.home_com[:2].copy()
        place[axis] += sign * high
        assert margin(polygon, place) > 0.01
    assert high > 0.04  # a sway of 4 cm is one of the project's examples


def test_the_polygon_is_the_hull_of_all_soles(robot: Robot) -> None:
    polygon = support_polygon(robot, robot.home.q)
    soles = robot.sole_placements(robot.home.q)
    feet = [sole.translation[:2] for sole in soles]
    x = [foot[0] + each for foot in feet for each in (-0.10, 0.10)]
    y = [foot[1] + each for foot in feet for each in (-0.05, 0.05)]
    assert len(polygon) == 4
    np.testing.assert_allclose(polygon.min(axis=0), [min(x), min(y)], atol=1e-9)
    np.testing.assert_allclose(polygon.max(axis=0), [max(x), max(y)], atol=1e-9)
    middle = polygon.mean(axis=0)
    assert margin(polygon, middle) == pytest.approx(0.10)
    assert margin(polygon, middle + np.array([0.12, 0.0])) == pytest.approx(-0.02)


def test_a_twist_ends_where_joints_do(robot: Robot) -> None:
    _, high = range_by_name(robot, Twist, "amplitude")
    assert 0.2 < high < 2.0
    with pytest.raises(InvalidValue, match=r"amplitude is 2, expected 0 to .* rad for herm"):
        check_motion(robot, Twist(2.0))


@pytest.mark.parametrize(
    ("edit", "field", "words"),
    [
        (lambda motions: motions.update(sqat={}), "motions.sqat", "did you mean 'squat'"),
        (
            lambda motions: motions["squat"].update(hight=[0.0, 0.1]),
            "motions.squat.hight",
            "amplitude, frequency, height; did you mean 'height'",
        ),
        (
            lambda motions: motions.update(sway={"height": [0.0, 0.1]}),
            "motions.sway.height",
            "one of amplitude, frequency",
        ),
    ],
)
def test_what_a_file_narrows_has_to_be_there(
    write_robot: Callable[..., Path], edit: Callable[[Any], None], field: str, words: str
) -> None:
    robot = load_robot(write_robot(lambda document: edit(document["motions"])))
    with pytest.raises(RobotFileError, match=words) as caught:
        check_motion(robot, Squat(0.03))
    assert caught.value.field == field


def usual_by_name(robot: Robot, kind: type[Motion], name: str) -> float | None:
    item = next(item for item in kind.declaration().parameters if item.name == name)
    return usual_of(robot, kind, item)


@pytest.mark.parametrize("kind", [Squat, Sway, Lean])
@pytest.mark.parametrize("largest", [0.011, 0.02, 0.5])
def test_what_is_usual_is_moved_into_the_robots_range(
    kind: type[Motion], largest: float, write_robot: Callable[..., Path]
) -> None:
    ranges = {"amplitude": [0.001, largest], "frequency": [0.3, 0.4]}
    narrow = load_robot(
        write_robot(lambda document: document["motions"].update({kind.name: ranges}))
    )
    usual = next(item.usual for item in kind.declaration().parameters if item.usual is not None)
    assert usual_by_name(narrow, kind, "amplitude") == min(usual, largest)
    assert usual_by_name(narrow, kind, "frequency") == 0.3


def test_what_is_usual_stays_where_the_robot_can_do_it(robot: Robot) -> None:
    assert usual_by_name(robot, Squat, "amplitude") == 0.03
    assert usual_by_name(robot, Squat, "frequency") == 0.25
    assert usual_by_name(robot, Squat, "height") == 0.0
