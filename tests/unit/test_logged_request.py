"""From the log of a run back to the request of a tick, and 'tsd explain'."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from tsd_casadi import Controller, InverseDynamics, Robot, Run, Squat, State, repeat
from tsd_casadi.exceptions import InvalidValue, SimulationError, TsdError
from tsd_casadi.repetition.record import record_of
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.format import Status
from tsd_cli import command_line
from tsd_clients import save_log
from tsd_clients.logs.logged_request import first_tick, logged_request
from tsd_clients.logs.read_log import read_log

PERIOD = 5e-3


class Follower:
    """A plant that accelerates as it was told: no contact, no model error, no surprise.

    Attributes:
        requests: Of all ticks, as the controller got them.
    """

    period, position_time, velocity_time = PERIOD, 0.0, 0.0

    def __init__(self, robot: Robot, controller: Controller) -> None:
        self.robot, self.format, self._controller = robot, controller.format, controller
        self.requests: list[np.ndarray] = []
        self.minimum_force = 5.0

    def command(self) -> Command:
        return self._controller.command()

    def tick(self, state: State, command: Command) -> object:
        command["left_foot.minimum_force"] = self.minimum_force
        if len(self.requests) >= 20 and self.minimum_force > 100:
            command["left_foot.extents"] = [0.1, 0.12, -0.05, 0.05]
            command["limits.torque"][self.robot.joint_names.index("L_AFE")] = 1.0
        self._tick = self._controller.tick(state, command)
        self.requests.append(command.request.copy())
        return self._tick

    def start(self, posture: State, seed: int = 0) -> None:
        self._state = State(posture.q.copy(), posture.v.copy())

    def measure(self) -> State:
        return self._state

    def truth(self) -> None:
        return None

    def settings(self) -> dict[str, object]:
        return {}

    def apply(self, tau: np.ndarray) -> None:
        import pinocchio

        v = self._state.v + PERIOD * self._tick.qdd
        self._state = State(pinocchio.integrate(self.robot.model, self._state.q, PERIOD * v), v)


def follow(robot: Robot, controller: Controller, minimum_force: float = 5.0) -> tuple[Run, list]:
    follower = Follower(robot, controller)
    follower.minimum_force = minimum_force
    run = repeat(follower, follower, Squat(0.03, 1.0), laps=2)  # type: ignore[arg-type]
    return run, follower.requests


@pytest.fixture(scope="module")
def usual(robot: Robot, controller: Controller) -> tuple[Run, list]:
    return follow(robot, controller)


@pytest.fixture(scope="module")
def failed(robot: Robot, controller: Controller) -> tuple[Run, list]:
    return follow(robot, controller, 600.0)


@pytest.mark.parametrize("ending", ["npz", "csv"])
def test_a_log_comes_back(usual: tuple[Run, list], tmp_path: Path, ending: str) -> None:
    run, _ = usual
    save_log(run, tmp_path / f"run.{ending}")
    log = read_log(tmp_path / f"run.{ending}")
    assert log.axes == run.axes and log.infeasible_request is None
    assert (log.robot, log.model) == ((run.robot, run.model) if ending == "npz" else ("", ""))
    assert set(log.fields) == set(run.log)
    for name, values in run.log.items():
        np.testing.assert_array_equal(log.fields[name], values)
        assert log.fields[name].dtype == values.dtype


@pytest.mark.parametrize("tick", [0, 250, 333, -2])
def test_tasks_ask_for_what_they_asked_for(
    usual: tuple[Run, list], problem: InverseDynamics, tmp_path: Path, tick: int
) -> None:
    """State to 32 bits; the cost's gradient, where all accelerations come together, as close."""
    run, requests = usual
    tick %= run.ticks
    save_log(run, tmp_path / "run.npz")
    rebuilt, rests_on = logged_request(read_log(tmp_path / "run.npz"), tick, problem)
    assert len(rests_on) > 1
    for name, first in (("q", 0), ("v", 0), ("com.reference", 0), ("torso.reference", 3)):
        place = problem.request.slice(name)  # of the torso only the orientation is controlled
        there = slice(place.start + first, place.stop)
        np.testing.assert_allclose(rebuilt[there], requests[tick][there], atol=2e-6)
    index = problem.terms.index_out("g")
    gradients = [
        np.array(problem.terms(each)[index])[: problem.nv, 0] for each in (rebuilt, requests[tick])
    ]
    np.testing.assert_allclose(*gradients, atol=1e-3 * np.abs(gradients[1]).max())


def test_the_first_failed_tick_is_kept_whole(
    failed: tuple[Run, list], problem: InverseDynamics, tmp_path: Path
) -> None:
    run, requests = failed
    tick = int(np.argmax(run.log["status"] == Status.INFEASIBLE))
    assert tick == 20
    save_log(run, tmp_path / "run.npz")
    log = read_log(tmp_path / "run.npz")
    assert first_tick(log) == tick
    request, rests_on = logged_request(log, tick, problem)
    np.testing.assert_array_equal(request, requests[tick])
    assert len(rests_on) == 1


def test_the_error_names_the_limits(failed: tuple[Run, list], robot: Robot) -> None:
    with pytest.raises(SimulationError, match=r"tick 20, at 0\.100 s.*joint_torque\.L_AFE"):
        record_of(failed[0], robot)


def test_without_an_infeasible_tick_there_is_no_reason(
    usual: tuple[Run, list], robot: Robot
) -> None:
    with pytest.raises(SimulationError) as caught:
        record_of(dataclasses.replace(usual[0], fell=True), robot)
    assert "without a solution" not in str(caught.value)


def test_other_robots_and_ticks_are_refused(
    usual: tuple[Run, list], problem: InverseDynamics, mini_biped: Robot, tmp_path: Path
) -> None:
    save_log(usual[0], tmp_path / "run.npz")
    log = read_log(tmp_path / "run.npz")
    with pytest.raises(InvalidValue, match="tick"):
        logged_request(log, usual[0].ticks, problem)
    with pytest.raises(InvalidValue, match="whose log this is"):
        logged_request(log, 0, InverseDynamics(mini_biped))
    with pytest.raises(InvalidValue, match="model"):
        logged_request(dataclasses.replace(log, model="other"), 0, problem)
    with pytest.raises(InvalidValue, match="sizes"):
        logged_request(dataclasses.replace(log, robot="", model=""), 0, InverseDynamics(mini_biped))
    missed = {**log.fields, "missed": np.ones_like(log.fields["missed"])}
    with pytest.raises(InvalidValue, match="no answer"):
        logged_request(dataclasses.replace(log, fields=missed), 0, problem)


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    for name, text in (("a.npz", "no"), ("b.csv", "time,phase\n1,2\n"), ("c.csv", "time\nx\n")):
        (tmp_path / name).write_text(text)
        with pytest.raises(TsdError, match=name):
            read_log(tmp_path / name)


def run_command(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    with pytest.raises(SystemExit) as caught:
        command_line.run(["explain", *arguments])
    assert caught.value.code == 0
    return capsys.readouterr().out


def test_the_command(
    failed: tuple[Run, list], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(tmp_path / "run.npz")
    save_log(failed[0], path)
    shown = run_command(capsys, path)
    assert "tick 20 at 0.100 s, infeasible" in shown and "left_foot.unilateral_force" in shown
    found = json.loads(run_command(capsys, path, "--json", "-"))
    assert (found["tick"], found["status"], found["feasible"]) == (20, "infeasible", False)
    assert {row["unit"] for row in found["conflict"]} == {"N", "N m"}
    earlier = json.loads(run_command(capsys, path, "--tick", "3", "--json", "-"))
    assert earlier["feasible"] and earlier["conflict"] == [] and len(earlier["notes"]) > 1
