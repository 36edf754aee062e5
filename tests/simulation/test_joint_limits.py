"""Joints at their limits, simulated: they stop, come back, and it is said."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.limits import random_states, wander
from tsd_casadi import Controller, Database, Robot, Squat, Status, load_robot
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.repetition.compensator import Compensator, Moment
from tsd_casadi.repetition.learn import learn
from tsd_casadi.state import State
from tsd_clients.console.run_tables import print_runs
from tsd_clients.simulator.simulator import MujocoSimulator

KNEE = "L_KFE"


class Stop(Compensator):
    """A stop in the way of the left knee."""

    def __init__(self, robot: Robot) -> None:
        self.place = robot.joint_names.index(KNEE)

    def before(self, moment: Moment) -> None:
        moment.command["limits.position_upper"][self.place] = 1.4


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


def test_learning_against_a_stop_is_said(
    robot: Robot, controller: Controller, tmp_path: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    said: list[str] = []
    with Database(tmp_path / "stop.db") as database:
        runs = learn(
            MujocoSimulator(robot),
            controller,
            [Squat(0.03, 0.5)],
            database,
            iterations=1,
            compensators=[Stop(robot)],
            on_run=lambda _, notes: said.extend(notes),
        )
        (entry,) = database.entries()
    assert set(runs[0].at_limits) == {KNEE}
    assert any(KNEE in note for note in said)
    tested = next(iteration for iteration in entry.iterations if iteration.circumstances)
    assert KNEE in tested.circumstances.setting["at_limits"]
    print_runs("runs", [{**run.summary(), "label": "run"} for run in runs])
    assert KNEE in capsys.readouterr().out


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
