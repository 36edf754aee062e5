"""Joints at their limits, simulated: they stop, come back, and it is said."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.limits import random_states, wander
from tsd_casadi import Controller, Database, Robot, Squat, Status, load_robot
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.compensator import Compensator, Moment
from tsd_casadi.repetition.learn import learn
from tsd_casadi.state import State
from tsd_clients.console.run_tables import print_runs
from tsd_clients.simulator.simulator import MujocoSimulator

# left knees, that bend with larger angles
KNEES = {"hermes_lower": "L_KFE", "g1": "left_knee_joint", "talos": "leg_left_4_joint"}


class Stop(Compensator):
    """A stop in the way of a left knee that bends, and what the controller says of it."""

    def __init__(self, robot: Robot) -> None:
        self.joint = KNEES[robot.name]
        self.place = robot.joint_names.index(self.joint)
        self.angle = robot.home.q[7 + self.place] + 0.02
        self.said = 0

    def before(self, moment: Moment) -> None:
        moment.command["limits.position_upper"][self.place] = self.angle

    def after(self, moment: Moment) -> None:
        assert moment.tick is not None
        self.said += f"joint_position.{self.joint}" in moment.tick.active


@pytest.mark.parametrize("name", ["hermes_lower", "g1", "talos"])
def test_limits_hold_in_a_run_and_at_random_states(name: str) -> None:
    robot = load_robot(name)
    controller = compile_controller(robot, on_compile=lambda: None)
    run = wander(robot, controller, 3.0, seed=0)
    print(run)
    assert run["fell"] is None
    assert run["failed"] == 0
    assert run["position"] <= 1e-3
    assert run["velocity"] <= 1e-2
    assert run["unsaid position"] == run["unsaid velocity"] == 0.0
    states = random_states(robot, controller, 500)
    print(states)
    assert states["beyond"] <= 1e-6
    assert states["failed only with the limits"] == 0
    assert states["at_limit"] > 0


@pytest.mark.parametrize("joint", ["L_KFE", "R_AFE", "L_HAA", "B_TFE"])
@pytest.mark.parametrize("end", ["lower", "upper"])
def test_a_start_slightly_outside_is_led_back(
    robot: Robot, controller: Controller, joint: str, end: str
) -> None:
    index = robot.joint_names.index(joint)
    simulator = MujocoSimulator(robot)
    command = controller.command()
    outside = 1e-3 if end == "lower" else -1e-3
    limit = command[f"limits.position_{end}"]
    limit[index] = robot.home.q[7 + index] + outside
    body = simulator.body(robot.home, robot.home)
    ways = []
    for tick in range(1000):
        true, state = body.measure()
        reply = controller.tick(state, command)
        assert reply.status == Status.OK
        ways.append((true.q[7 + index] - limit[index]) * np.sign(outside))
        if tick == 0:
            assert f"joint_position.{joint}" in reply.active
        body.step(reply.tau, tick * 1e-3)
    assert ways[0] == pytest.approx(-1e-3)
    assert ways[-1] >= 0
    assert np.diff(ways[:200]).min() > -1e-5


@pytest.mark.parametrize("name", KNEES)
def test_learning_against_a_stop_is_said(
    name: str, tmp_path: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the controller, in the run and its table, by ``learn`` and in the entry."""
    robot = load_robot(name)
    controller, stop = compile_controller(robot, on_compile=lambda: None), Stop(robot)
    said: list[str] = []
    with Database(tmp_path / "stop.db") as database:
        runs = learn(
            MujocoSimulator(robot),
            controller,
            [Squat(0.02, 1.0)],
            database,
            iterations=1,
            compensators=[stop],
            on_run=lambda _, notes: said.extend(notes),
        )
        (entry,) = database.entries()
    knee = stop.joint
    counts = [run.at_limits for run in runs]
    assert [set(count) for count in counts] == [{knee}, {knee}]
    assert stop.said == pytest.approx(sum(count[knee] for count in counts), rel=0.2)
    for run in runs:
        angles = run.log["q"][:, 7 + stop.place]
        assert stop.angle - 0.01 < angles.max() < stop.angle + 1e-3
    assert sum(knee in note for note in said) == 2
    tested = next(iteration for iteration in entry.iterations if iteration.circumstances)
    assert knee in tested.circumstances.setting["at_limits"]
    print_runs("runs", [{**run.summary(), "label": "run"} for run in runs])
    assert knee in capsys.readouterr().out


@pytest.mark.parametrize("name", KNEES)
def test_a_lap_that_meets_a_stop_of_the_robot_is_not_learned(name: str, tmp_path: Any) -> None:
    """Where the limits are those of the robot it is known before anything moves."""
    robot = load_robot(name)
    controller = compile_controller(robot, on_compile=lambda: None)
    with Database(tmp_path / "stop.db") as database, pytest.raises(InvalidValue, match="amplitude"):
        learn(MujocoSimulator(robot), controller, [Squat(0.4, 0.25)], database)


def test_nothing_is_said_in_the_middle(robot: Robot, controller: Controller) -> None:
    run = MujocoSimulator(robot).run(controller, Squat(0.03, 0.5), laps=2)
    assert run.at_limits == {}


def test_velocity_limits_hold(robot: Robot, controller: Controller) -> None:
    command = controller.command()
    command["limits.velocity"] = 0.2
    command["posture.q_ref"] = robot.home.q[7:]
    com = command["com.reference"]
    com[2] -= 0.08
    simulator = MujocoSimulator(robot)
    body, fastest, named = simulator.body(robot.home, robot.home), 0.0, set()
    for tick in range(1000):
        true, state = body.measure()
        reply = controller.tick(State(state.q, state.v), command)
        named |= set(reply.active)
        fastest = max(fastest, float(np.abs(true.v[6:]).max()))
        body.step(reply.tau, tick * 1e-3)
    assert fastest <= 0.2 + 1e-2
    assert any(name.startswith("joint_velocity.") for name in named)
