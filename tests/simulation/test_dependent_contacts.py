"""Robots that the ground holds in more ways than they can move: simulated, they just move."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tsd_casadi import Squat, compile_controller, load_robot
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.sway import Sway
from tsd_clients import MujocoSimulator

ROBOTS = Path(__file__).parents[1] / "robots"
BEGUN = 0.5  # s
# of a joint's limit, per tick: rows that drop out and come in are not to be felt
LARGEST_CHANGE = 0.02


@pytest.mark.parametrize(
    ("file", "motion"),
    [
        ("mini_biped/five_joints.yaml", Squat(0.03, 1.0)),
        ("mini_biped/five_joints.yaml", Sway(0.008, 1.0)),  # narrow feet
        ("mini_quadruped/two_joints.yaml", Squat(0.03, 1.0)),
    ],
)
def test_torques_do_not_jump_while_it_moves(file: str, motion: Motion) -> None:
    robot = load_robot(ROBOTS / file)
    controller = compile_controller(robot, on_compile=lambda: None)
    run = MujocoSimulator(robot, 0.1).run(controller, motion, laps=2)
    assert not run.fell
    assert run.failures == {}
    begun = run.log["tau"][run.log["time"] > BEGUN]
    change = np.abs(np.diff(begun, axis=0)) / robot.torque_limit
    print(robot.name, motion.name, change.max())
    assert change.max() < LARGEST_CHANGE
    axis = motion.axes(robot)[0]
    moved = run.along("reference", axis)[run.log["measured"]]
    # with a model that is 10 % wrong: an offset, and what moves with it
    ac_rms = run.errors[axis].ac_rms
    assert ac_rms is not None and ac_rms < 0.1 * np.ptp(moved)
