"""The reach; what holds for every motion is in test_motions.py."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.parameter import Parameter
from tsd_casadi.motions.ranges import check_motion, range_of
from tsd_casadi.motions.reach import Reach


@pytest.mark.parametrize(
    ("direction", "elevation", "line"),
    [
        (0.0, 0.0, (1, 0, 0)),
        (math.pi / 2, 0.0, (0, 1, 0)),
        (0.3, math.pi / 2, (0, 0, 1)),
        (0.0, math.pi / 4, (math.sqrt(0.5), 0, math.sqrt(0.5))),
    ],
)
def test_it_goes_along_its_line(
    direction: float, elevation: float, line: tuple[float, ...]
) -> None:
    reach = Reach(0.1, 0.25, direction, elevation)
    assert reach.offset(math.pi / 2).x == pytest.approx([0.1 * each for each in line], abs=1e-15)


def test_a_robot_without_such_a_task_is_told_what_it_has(robot: Robot) -> None:
    with pytest.raises(InvalidValue, match=r"hermes_lower .*torso \(rx ry rz\).*robot file"):
        Reach(0.01).axes(robot)
    with pytest.raises(InvalidValue, match="frame task"):
        check_motion(robot, Reach(0.01))


def test_a_frame_with_a_task_of_its_place_can_reach(write_robot: Callable[..., Path]) -> None:
    def hold_the_torso(document: dict[str, Any]) -> None:
        document["tasks"][2]["axes"] = ["x", "y", "z", "rx", "ry", "rz"]

    armed = load_robot(write_robot(hold_the_torso))
    reach = Reach(0.01)
    assert reach.axes(armed) == ("torso.x", "torso.y", "torso.z")
    amplitude = next(item for item in Reach.declaration().parameters if item.extent)
    assert isinstance(amplitude, Parameter)
    low, high = range_of(armed, Reach, amplitude)
    assert low == 0.0 <= high < 1.0
