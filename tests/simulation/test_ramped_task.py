"""The bounded form of ``python -m benchmarks.ramped_task``."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.ramped_task import BACK, OUT, RAMP, compare, level_at, meets_the_goal
from tsd_casadi import Controller, Robot


def test_a_frame_task_leaves_and_comes_without_a_jump(robot: Robot, controller: Controller) -> None:
    result = compare(robot, controller, "torso", 0)
    print(result)
    assert meets_the_goal(result)
    # the switch is what it is compared with: it does jump
    assert result["switch"]["largest_step"] > 20 * result["ramp"]["largest_step"]
    assert not meets_the_goal({"ramp": result["switch"]})


@pytest.mark.parametrize("ramp", [0.0, RAMP])
def test_a_task_is_there_gone_and_back(ramp: float) -> None:
    before, after = 1e-9, 1e-9
    assert level_at(OUT - before, ramp) == level_at(BACK + ramp + after, ramp) == 1.0
    assert level_at(OUT + ramp + after, ramp) == level_at(BACK - before, ramp) == 0.0
    middle = [level_at(start + ramp / 2, ramp) for start in (OUT, BACK)]
    assert ramp == 0.0 or np.allclose(middle, 0.5)
