from __future__ import annotations

import pytest

from tsd_casadi import Robot
from tsd_casadi.exceptions import InvalidValue
from tsd_cli.commands.region import parse_region


def test_ranges_are_read(robot: Robot) -> None:
    texts = ["amplitude=0.02:0.08", "frequency=0.2:6e-1", "height=-0.02:0.01"]
    assert parse_region(texts, robot) == {
        "amplitude": (0.02, 0.08),
        "frequency": (0.2, 0.6),
        "height": (-0.02, 0.01),
    }


def test_a_name_alone_is_the_robots_range(robot: Robot) -> None:
    squat = robot.description.motions.squat
    assert parse_region(["height", "amplitude"], robot) == {
        "height": squat.height,
        "amplitude": squat.amplitude,
    }


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
        parse_region([text], robot)


@pytest.mark.parametrize(
    "text", ["amplitude=0.08:0.02", "amplitude=0.02:0.02", "amplitude=0.02:0.5", "height=nan:0"]
)
def test_ranges_beyond_the_robots_are_refused(robot: Robot, text: str) -> None:
    with pytest.raises(InvalidValue, match=f"low before high.*{robot.name}"):
        parse_region([text], robot)


def test_a_parameter_has_one_range(robot: Robot) -> None:
    with pytest.raises(InvalidValue, match="each name once"):
        parse_region(["amplitude=0.02:0.04", "amplitude=0.05:0.06"], robot)
