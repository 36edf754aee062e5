from __future__ import annotations

import pytest

from tsd_casadi import Robot, Squat
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.file import File
from tsd_casadi.motions.sway import Sway
from tsd_casadi.motions.twist import Twist
from tsd_cli.actions.region import default_ends, default_name, describe_chosen, read_region


def test_ranges_are_read(robot: Robot) -> None:
    texts = ["amplitude=0.02:0.08", "frequency=0.2:6e-1", "height=-0.02:0.01"]
    assert read_region(texts, robot, Squat) == {
        "amplitude": (0.02, 0.08),
        "frequency": (0.2, 0.6),
        "height": (-0.02, 0.01),
    }


def test_a_name_alone_is_from_a_quarter_of_the_largest_on(robot: Robot) -> None:
    squat = robot.description.motions["squat"].ranges
    assert read_region(["height", "amplitude", "frequency"], robot, Squat) == {
        "height": squat["height"],  # zero lies inside
        "amplitude": (0.02, 0.08),
        "frequency": (0.25, 1.0),
    }


@pytest.mark.parametrize(
    ("lowest", "highest", "ends"),
    [(0.001, 0.08, (0.02, 0.08)), (0.03, 0.08, (0.03, 0.08)), (0.0, 4.0, (1.0, 4.0))],
)
def test_sizes_that_teach_nothing_are_left_out(
    lowest: float, highest: float, ends: tuple[float, float]
) -> None:
    assert default_ends(lowest, highest) == ends


def test_what_was_chosen_is_said_with_unit_and_how_to_choose(robot: Robot) -> None:
    texts = ["amplitude", "frequency=0.2:0.6", "height"]
    lines = describe_chosen(texts, read_region(texts, robot, Squat), Squat)
    assert lines == [
        "region of amplitude: 0.02 to 0.08 m; --region amplitude=LOW:HIGH for another",
        "region of height: -0.05 to 0.06 m; --region height=LOW:HIGH for another",
    ]


@pytest.mark.parametrize("text", ["heigth", "heigth=0:0.01"])
def test_a_mistyped_name_is_shown_beside_those_there_are(robot: Robot, text: str) -> None:
    with pytest.raises(InvalidValue, match=r"amplitude, frequency, height; did you mean 'height'"):
        read_region([text], robot, Squat)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "depth=0:1",
        "amplitude=0.02",
        "amplitude=0.02:",
        "amplitude=:",
        "amplitude=0.02:0.04:0.06",
        "amplitude=small:large",
        "=0.02:0.04",
    ],
)
def test_what_cannot_be_read_is_refused_with_an_example(robot: Robot, text: str) -> None:
    with pytest.raises(InvalidValue, match=r"amplitude=0\.02:0\.08"):
        read_region([text], robot, Squat)


@pytest.mark.parametrize(
    "text", ["amplitude=0.08:0.02", "amplitude=0.02:0.02", "amplitude=0.02:0.5", "height=nan:0"]
)
def test_ranges_beyond_the_robots_are_refused(robot: Robot, text: str) -> None:
    with pytest.raises(InvalidValue, match=f"low before high.*{robot.name}"):
        read_region([text], robot, Squat)


def test_a_parameter_has_one_range(robot: Robot) -> None:
    with pytest.raises(InvalidValue, match="each name once"):
        read_region(["amplitude=0.02:0.04", "amplitude=0.05:0.06"], robot, Squat)


def test_regions_are_of_any_motion(robot: Robot) -> None:
    assert read_region(["amplitude=0.1:0.2"], robot, Twist) == {"amplitude": (0.1, 0.2)}
    (line,) = describe_chosen(["amplitude"], {"amplitude": (0.1, 0.2)}, Twist)
    assert line.startswith("region of amplitude: 0.1 to 0.2 rad;")
    with pytest.raises(InvalidValue, match="with one of amplitude, frequency"):
        read_region(["height=0:0.01"], robot, Sway)


def test_what_is_varied_where_nobody_says_is_how_far_it_goes() -> None:
    assert [default_name(kind) for kind in (Squat, Twist, File)] == [
        "amplitude",
        "amplitude",
        "scale",
    ]
