from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest

import tsd_casadi.repetition.repetition
from tsd_casadi import (
    Command,
    Controller,
    Feedforward,
    PeriodicBasis,
    Robot,
    Run,
    Squat,
    State,
    Tick,
)
from tsd_casadi import load_robot as load
from tsd_casadi.encoding.laps import first_steady_lap
from tsd_casadi.exceptions import InvalidValue, ParityError, RobotFileError, SimulationError
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.repetition.repetition import EXTRA_LAPS, HOLD
from tsd_casadi.tick.format import Status, TickFormat
from tsd_clients import MujocoSimulator
from tsd_clients.logs.log_file import save_log
from tsd_clients.simulator.disturbances import Disturbance, Push
from tsd_clients.simulator.effects import EFFECTS
from tsd_clients.simulator.mujoco_plant import TIMESTEP
from tsd_clients.simulator.simulator import START_NOISE
from tsd_clients.simulator.state_map import StateMap

SQUAT = Squat(amplitude=0.01, frequency=1.0)
HOLD_TICKS = round(HOLD / TIMESTEP)
LAP_TICKS = 1000
TIMES = ("tick_us", "compute_us")


class Stub:
    """A controller whose reply to the n-th tick is edited by a function."""

    def __init__(
        self, controller: Controller, edit: Callable[[int, Tick], None], solve: bool = True
    ) -> None:
        self.format: TickFormat = controller.format
        self.ticks = 0
        self._controller = controller
        self._edit = edit
        self._solve = solve

    def command(self) -> Command:
        return self._controller.command()

    def tick(self, state: State, command: Command) -> Tick:
        if self._solve:
            tick = self._controller.tick(state, command)
        else:
            tick = Tick(self.format, np.zeros(self.format.reply.size))
        self._edit(self.ticks, tick)
        self.ticks += 1
        return tick


def limp(controller: Controller) -> Stub:
    """Zero torque, status ok."""
    return Stub(controller, lambda number, tick: None, solve=False)


@pytest.fixture(scope="module")
def a_feedforward() -> Feedforward:
    basis = PeriodicBasis()
    phase = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    weights = basis.fit(phase, -0.7 - 0.05 * np.sin(phase + 0.5)[None, :])
    return Feedforward(("com.z",), basis, weights, np.zeros_like(weights), "learned")


@pytest.fixture(scope="module")
def run(simulator: MujocoSimulator, controller: Controller) -> Run:
    return simulator.run(controller, SQUAT, laps=2)


@pytest.fixture(scope="module")
def fed_run(simulator: MujocoSimulator, controller: Controller, a_feedforward: Feedforward) -> Run:
    return simulator.run(controller, SQUAT, laps=2, feedforward=a_feedforward, gains=Gains(P=0.5))


@pytest.fixture(scope="module")
def fallen(simulator: MujocoSimulator, controller: Controller) -> Run:
    return simulator.run(limp(controller), SQUAT, laps=2)


# the simulated robot


@pytest.mark.parametrize("model_error", [-0.5, 0.0, 0.1, 1.0])
def test_the_controllers_masses_are_one_plus_e_times_the_simulated_ones(
    robot: Robot, model_error: float
) -> None:
    exact = mujoco.MjModel.from_xml_path(str(robot.scene_path))
    model = MujocoSimulator(robot, model_error).model
    factor = 1 + model_error
    np.testing.assert_allclose(model.body_mass * factor, exact.body_mass, rtol=1e-14)
    np.testing.assert_allclose(model.body_inertia * factor, exact.body_inertia, rtol=1e-14)
    np.testing.assert_array_equal(model.body_ipos, exact.body_ipos)
    # what MuJoCo derives from them is derived again
    np.testing.assert_allclose(model.body_subtreemass * factor, exact.body_subtreemass, rtol=1e-12)
    np.testing.assert_allclose(
        model.dof_invweight0 / factor, exact.dof_invweight0, rtol=1e-9, atol=1e-12
    )


def test_the_simulated_weight_is_what_the_feet_carry(run: Run, robot: Robot) -> None:
    standing = run.log["wrenches"][HOLD_TICKS - 100 : HOLD_TICKS]
    vertical = standing[:, [2, 8]].sum(axis=1)
    # not that of the robot which the controller knows: its feedback takes the rest off
    assert vertical.mean() == pytest.approx(robot.weight / 1.1, rel=0.02)


@pytest.mark.parametrize("model_error", [-1.0, -0.91, 9.1, np.nan, np.inf])
def test_impossible_model_errors_are_refused(robot: Robot, model_error: float) -> None:
    with pytest.raises(InvalidValue, match="model error"):
        MujocoSimulator(robot, model_error)


def test_a_scene_of_another_body_is_refused(write_robot: Callable[..., Path]) -> None:
    path = write_robot(urdf=lambda text: text.replace('mass value="22.85"', 'mass value="22.86"'))
    with pytest.raises(ParityError, match="mass matrix"):
        MujocoSimulator(load(path))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<mujoco>",
        "no XML",
        "<mujoco><option gravity='x'/></mujoco>",
        '<mujoco><include file="nowhere.xml"/></mujoco>',
    ],
)
def test_a_scene_that_cannot_be_loaded_is_refused(
    write_robot: Callable[..., Path], text: str
) -> None:
    path = write_robot()
    (path.parent / "scene.xml").write_text(text)
    with pytest.raises(RobotFileError, match=r"scene\.xml.*cannot be loaded"):
        MujocoSimulator(load(path))


def test_starts_at_home_with_soles_on_the_ground_on_average(
    simulator: MujocoSimulator, robot: Robot
) -> None:
    state = simulator.start(robot.home, seed=4)
    offset = state.q[7:] - robot.home.q[7:]
    assert 0.5 * START_NOISE < np.abs(offset).max() <= START_NOISE
    assert not state.v.any()
    np.testing.assert_array_equal(state.q[[0, 1, 3, 4, 5, 6]], robot.home.q[[0, 1, 3, 4, 5, 6]])
    heights = [robot.frame_placement(sole, state.q)[0][2] for sole in ("L_sole", "R_sole")]
    assert np.mean(heights) == pytest.approx(0, abs=1e-12)


def test_start_depends_on_the_seed_only(simulator: MujocoSimulator, robot: Robot) -> None:
    one, again, other = (simulator.start(robot.home, seed).q for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    assert np.abs(one - other).max() > 1e-5


# a run


def test_squats_about_another_height(simulator: MujocoSimulator, controller: Controller) -> None:
    run = simulator.run(controller, Squat(0.01, 1.0, height=0.05), laps=2)
    assert run.steady
    assert run.failures == {}
    assert run.log["reference"][0] == pytest.approx(simulator.robot.home_com[2] + 0.05, abs=1e-9)
    # the robot, not only the reference, is up there
    height = run.log["reference"] - run.log["true_error"]
    assert height[run.log["measured"]].mean() == pytest.approx(run.log["reference"][0], abs=0.03)
    data = simulator.robot.model.createData()
    q = run.log["q"][HOLD_TICKS - 1].astype(float)
    assert pinocchio.centerOfMass(simulator.robot.model, data, q)[2] == pytest.approx(
        height[HOLD_TICKS - 1], abs=1e-6
    )
    knee = 7 + simulator.robot.joint_names.index("L_KFE")
    assert q[knee] < simulator.robot.home.q[knee] - 0.2


@pytest.mark.parametrize("height", [-0.05, 0.06])
def test_the_ends_of_the_height_range_are_steady(
    simulator: MujocoSimulator, controller: Controller, height: float
) -> None:
    run = simulator.run(controller, Squat(0.02, 1.0, height), laps=2)
    assert (run.steady, run.fell, run.failures) == (True, False, {})


# hardware


@pytest.mark.parametrize("effect", EFFECTS)
def test_each_hardware_effect_alone_is_steady(
    robot: Robot, controller: Controller, effect: str
) -> None:
    run = MujocoSimulator(robot, 0.1, [effect]).run(controller, SQUAT, laps=2)
    assert (run.steady, run.fell, run.failures) == (True, False, {})
    assert run.settings["hardware"] == [effect]
    without = MujocoSimulator(robot, 0.1).run(controller, SQUAT, laps=2)
    assert run.rms_error != without.rms_error
    assert run.rms_error == pytest.approx(without.rms_error, rel=0.5)


@pytest.fixture(scope="module")
def hard_run(robot: Robot, controller: Controller) -> Run:
    simulator = MujocoSimulator(robot, 0.1, ["all"])
    return simulator.run(controller, Squat(0.02, 0.5), laps=2)


def test_all_hardware_together_is_steady(hard_run: Run) -> None:
    assert (hard_run.steady, hard_run.fell, hard_run.failures) == (True, False, {})
    assert hard_run.settings["hardware"] == list(EFFECTS)
    # feet on a rigid floor: the sensors are good enough to know the robot's error by
    assert hard_run.true_rms_error == pytest.approx(hard_run.rms_error, rel=0.01)


def test_hardware_leaves_an_error_that_changes_within_a_lap(
    robot: Robot, controller: Controller, hard_run: Run
) -> None:
    # friction turns with the velocity, an offset does not
    bodies = MujocoSimulator(robot, 0.1).run(controller, Squat(0.02, 0.5), laps=2)
    assert hard_run.ac_rms_error > 5 * bodies.ac_rms_error


def test_the_records_keep_the_true_state_and_the_command(
    hard_run: Run, robot: Robot, controller: Controller
) -> None:
    assert (np.abs(hard_run.log["tau"]) <= robot.torque_limit).all()
    data = robot.model.createData()
    tick = hard_run.ticks // 2
    com = pinocchio.centerOfMass(robot.model, data, hard_run.log["q"][tick].astype(float))
    height = hard_run.log["reference"][tick] - hard_run.log["true_error"][tick]
    assert com[2] == pytest.approx(height, abs=1e-6)


def test_runs_with_noisy_sensors_depend_on_the_seed_only(
    robot: Robot, controller: Controller
) -> None:
    simulator = MujocoSimulator(robot, 0.1, ["noise", "differencing"])
    one, again, other = (
        simulator.run(controller, SQUAT, laps=2, seed=seed).log["error"] for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, again)
    size = min(len(one), len(other))
    assert (one[:size] != other[:size]).mean() > 0.9


def test_unknown_hardware_is_refused(robot: Robot) -> None:
    with pytest.raises(InvalidValue, match="hardware is rust"):
        MujocoSimulator(robot, hardware=["rust"])


# disturbances


def test_a_push_throws_off_the_error_and_is_recovered_from(
    simulator: MujocoSimulator, controller: Controller, run: Run
) -> None:
    push = Push(start=HOLD + 0.5, duration=0.05, impulse=(0.0, 0.0, -20.0))
    pushed = simulator.run(controller, SQUAT, laps=3, disturbances=[push])
    assert not pushed.fell
    off = np.abs(pushed.log["error"][: run.ticks] - run.log["error"])
    first = HOLD_TICKS + 500
    assert not off[: first + 1].any()
    assert off[first : first + 200].max() > 5e-3
    assert off[HOLD_TICKS + 2 * LAP_TICKS : HOLD_TICKS + 3 * LAP_TICKS].max() < 1e-3


# repeating


def test_runs_with_the_same_seed_are_identical(
    simulator: MujocoSimulator, controller: Controller, run: Run
) -> None:
    again = simulator.run(controller, SQUAT, laps=2)
    for name, values in run.log.items():
        if name not in TIMES:
            np.testing.assert_array_equal(again.log[name], values, err_msg=name)
    assert again.errors() == run.errors()


def test_runs_with_different_seeds_differ_a_little(
    simulator: MujocoSimulator, controller: Controller, run: Run
) -> None:
    other = simulator.run(controller, SQUAT, laps=2, seed=1)
    assert np.abs(other.log["q"][0] - run.log["q"][0]).max() > 1e-5
    assert other.rms_error != run.rms_error
    assert other.rms_error == pytest.approx(run.rms_error, rel=0.02)


def test_holds_then_does_whole_laps(run: Run) -> None:
    assert run.steady
    assert not run.fell
    assert run.failures == {}
    assert run.ticks == HOLD_TICKS + run.laps_run * LAP_TICKS
    lap = run.log["lap"]
    assert (lap[:HOLD_TICKS] == -1).all()
    for number in range(run.laps_run):
        assert (lap == number).sum() == LAP_TICKS
    assert (np.diff(lap) >= 0).all()
    np.testing.assert_allclose(np.diff(run.log["time"]), TIMESTEP, rtol=1e-6)


def test_reference_is_the_motion_about_home(run: Run, robot: Robot) -> None:
    elapsed = run.log["phase"] - np.pi
    assert (elapsed[:HOLD_TICKS] == 0).all()
    expected = robot.home_com[2] + np.array([SQUAT.reference(e).x for e in elapsed])
    np.testing.assert_allclose(run.log["reference"], expected, atol=1e-12)
    np.testing.assert_allclose(
        elapsed[HOLD_TICKS:], 2 * np.pi * TIMESTEP * np.arange(run.ticks - HOLD_TICKS), atol=1e-9
    )


def test_log_is_documented_and_complete(run: Run) -> None:
    n, contacts = run.log["tau"].shape[1], run.log["wrenches"].shape[1] // 6
    axes = run.log["all_errors"].shape[1]
    shapes = {
        "()": (),
        "(k,)": (axes,),
        "(n,)": (n,),
        "(7 + n,)": (7 + n,),
        "(6 + n,)": (6 + n,),
        "(6 c,)": (6 * contacts,),
    }
    assert run.log.keys() == LOG_FIELDS.keys()
    for name, values in run.log.items():
        field = LOG_FIELDS[name]
        assert np.isfinite(values).all(), name
        assert values.shape == (run.ticks, *shapes[field.shape]), name
        assert values.dtype == field.type, name


def test_true_error_is_that_of_the_logged_state(run: Run, robot: Robot) -> None:
    data = robot.model.createData()
    for tick in range(0, run.ticks, 250):
        q = run.log["q"][tick].astype(float)
        height = pinocchio.centerOfMass(robot.model, data, q)[2]
        expected = run.log["reference"][tick] - height
        assert run.log["true_error"][tick] == pytest.approx(expected, abs=1e-6)


def test_a_uniform_model_error_leaves_the_centre_of_mass_where_it_is(run: Run) -> None:
    # so what the controller sees is the truth, at the same instant
    np.testing.assert_allclose(run.log["error"], run.log["true_error"], atol=1e-9)


def test_feedback_is_p_times_error_plus_d_times_its_rate(run: Run) -> None:
    (P, D) = (run.gains["P"][2], run.gains["D"][2])
    rate = np.gradient(run.log["error"], TIMESTEP)
    expected = P * run.log["error"] + D * rate
    late = slice(HOLD_TICKS + LAP_TICKS, run.ticks - 1)
    np.testing.assert_allclose(run.log["feedback"][late], expected[late], atol=0.01)
    assert np.std(run.log["feedback"][late]) > 0.01  # there was something to compare


def test_feedforward_is_that_of_the_phase_and_constant_while_holding(
    fed_run: Run, run: Run, a_feedforward: Feedforward
) -> None:
    assert not run.log["feedforward"].any()
    expected = a_feedforward.mean(fed_run.log["phase"])[0]
    np.testing.assert_allclose(fed_run.log["feedforward"], expected, atol=1e-12)
    start = a_feedforward.mean([np.pi])[0, 0]
    np.testing.assert_allclose(fed_run.log["feedforward"][:HOLD_TICKS], start, atol=1e-12)
    assert np.ptp(fed_run.log["feedforward"]) > 0.05


def test_a_factor_on_p_multiplies_p_and_only_p(
    fed_run: Run, run: Run, controller: Controller
) -> None:
    for field in ("P", "D", "W"):
        default = controller.command()[f"com.{field}"]
        np.testing.assert_array_equal(run.gains[field], default)
        factor = 0.5 if field == "P" else 1.0
        np.testing.assert_array_equal(fed_run.gains[field], factor * default)


def test_both_gains_reach_the_controller_and_no_other_task(
    simulator: MujocoSimulator, controller: Controller
) -> None:
    seen: list[Command] = []

    class Watched(Stub):
        def tick(self, state: State, command: Command) -> Tick:
            seen.append(command.copy())
            return super().tick(state, command)

    limp_one = Watched(controller, lambda number, tick: None, solve=False)
    simulator.run(limp_one, SQUAT, laps=2, gains=Gains(P=0.5, D=2.0))
    default, given = controller.command(), seen[0]
    np.testing.assert_array_equal(given["com.P"], 0.5 * default["com.P"])
    np.testing.assert_array_equal(given["com.D"], 2.0 * default["com.D"])
    for name in ("com.W", "pelvis.P", "torso.D", "posture.P"):
        np.testing.assert_array_equal(given[name], default[name])


def test_feedforward_takes_the_error_off(fed_run: Run, run: Run) -> None:
    # at half the stiffness, too
    assert fed_run.rms_error < 0.2 * run.rms_error


def test_settings_and_feedforward_are_kept(
    simulator: MujocoSimulator, fed_run: Run, a_feedforward: Feedforward
) -> None:
    assert fed_run.settings == {
        "model_error": 0.1,
        "hardware": [],
        "p_scale": 0.5,
        "d_scale": 1.0,
        "transport": "local",
        "seed": 0,
    }
    assert fed_run.feedforward is a_feedforward
    assert fed_run.robot == "hermes_lower"
    assert fed_run.motion == SQUAT


def test_metrics_are_those_of_the_measured_ticks(run: Run) -> None:
    measured = run.log["measured"]
    error = run.log["error"][measured]
    assert run.rms_error == pytest.approx(np.sqrt((error**2).mean()))
    assert run.ac_rms_error == pytest.approx(error.std())
    assert run.peak_error == np.abs(error).max()
    true = run.log["true_error"][measured]
    assert run.true_rms_error == pytest.approx(np.sqrt((true**2).mean()))
    assert run.mean_abs_feedback == pytest.approx(np.abs(run.log["feedback"][measured]).mean())


def test_measured_are_exactly_the_steady_laps(run: Run) -> None:
    log = run.log
    whole = [(log["phase"][log["lap"] == n], log["feedback"][log["lap"] == n]) for n in range(9)]
    kept = whole[run.laps_run - len(run.laps) : run.laps_run]
    assert 2 <= len(run.laps) <= run.laps_run
    for lap, (phase, feedback) in zip(run.laps, kept, strict=True):
        np.testing.assert_array_equal(lap.phase, phase)
        np.testing.assert_array_equal(lap.feedback, feedback[None, :])
    assert log["measured"].sum() == len(run.laps) * LAP_TICKS
    assert log["measured"][-len(run.laps) * LAP_TICKS :].all()
    assert first_steady_lap(run.laps) == 0


def test_progress_never_goes_back_and_reaches_the_end(
    simulator: MujocoSimulator, controller: Controller
) -> None:
    calls: list[tuple[float, float]] = []
    simulator.run(controller, SQUAT, laps=2, progress=lambda *call: calls.append(call))
    done = [call[0] for call in calls]
    assert done == sorted(done)
    assert all(0 <= part <= total for part, total in calls)
    assert calls[-1][0] == calls[-1][1]


# laps until steady


def _drifting(changes: list[float]) -> Callable[[int, Tick], None]:
    """Adds to the feedback, lap by lap; the last value stays."""

    def edit(number: int, tick: Tick) -> None:
        lap = max((number - HOLD_TICKS) // LAP_TICKS, 0)
        tick.feedback[:] += changes[min(lap, len(changes) - 1)]

    return edit


@pytest.mark.parametrize(("changes", "laps_run"), [([2, 1, 0], 4), ([4, 3, 2, 1, 0], 6)])
def test_laps_are_added_until_the_last_two_agree(
    simulator: MujocoSimulator, controller: Controller, changes: list[float], laps_run: int
) -> None:
    stub = Stub(controller, _drifting(changes))
    run = simulator.run(stub, SQUAT, laps=2)
    assert (run.steady, run.laps_run, len(run.laps)) == (True, laps_run, 2)


def test_laps_that_were_asked_for_are_done_though_steady_before(
    simulator: MujocoSimulator, controller: Controller
) -> None:
    run = simulator.run(controller, SQUAT, laps=4)
    assert run.laps_run == 4
    assert len(run.laps) >= 2


def test_what_never_settles_is_said_not_to_and_measured_over_two_laps(
    simulator: MujocoSimulator, controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert EXTRA_LAPS >= 5
    monkeypatch.setattr(tsd_casadi.repetition.repetition, "EXTRA_LAPS", 2)
    stub = Stub(controller, _drifting([float(lap) for lap in range(10)]))
    run = simulator.run(stub, SQUAT, laps=2)
    assert (run.steady, run.fell, run.laps_run, len(run.laps)) == (False, False, 4, 2)
    assert run.log["measured"].sum() == 2 * LAP_TICKS
    assert run.rms_error > 0


# what goes wrong


def test_a_robot_without_torque_falls_and_is_reported(fallen: Run, robot: Robot) -> None:
    assert fallen.fell
    assert not fallen.steady
    assert (fallen.laps, fallen.laps_run, fallen.failures) == ([], 0, {})
    assert 100 < fallen.ticks < HOLD_TICKS  # it takes its time, then the run ends
    assert not fallen.log["measured"].any()
    height = robot.home_com[2] - fallen.log["true_error"]
    assert height[0] == pytest.approx(robot.home_com[2], abs=0.01)
    assert height[-1] < 0.62 * robot.home_com[2]
    assert not fallen.log["tau"].any()


def test_a_fall_in_the_middle_of_a_lap_ends_the_run(
    simulator: MujocoSimulator, controller: Controller
) -> None:
    last = HOLD_TICKS + LAP_TICKS + 500

    def give_up(number: int, tick: Tick) -> None:
        if number >= last:
            tick.tau[:] = 0

    run = simulator.run(Stub(controller, give_up), SQUAT, laps=3)
    assert run.fell
    assert (run.laps_run, run.laps, run.steady) == (1, [], False)
    assert last < run.ticks < last + 2000
    assert not run.log["measured"].any()


def test_a_fallen_run_can_be_summarised_and_saved(fallen: Run, tmp_path: Path) -> None:
    summary = json.loads(json.dumps(fallen.summary()))
    assert summary["fell"] is True
    assert summary["laps_measured"] == 0
    save_log(fallen, tmp_path / "log.npz")
    with np.load(tmp_path / "log.npz") as saved:
        assert len(saved["time"]) == fallen.ticks


def test_failures_are_counted_by_name(simulator: MujocoSimulator, controller: Controller) -> None:
    statuses = {500: Status.INFEASIBLE, 501: Status.INFEASIBLE, 2500: Status.ITERATION_LIMIT}

    def fail(number: int, tick: Tick) -> None:
        tick.reply[0] = statuses.get(number, Status.OK)

    run = simulator.run(Stub(controller, fail), SQUAT, laps=2)
    assert run.failures == {"infeasible": 2, "iteration_limit": 1}
    assert not run.fell
    np.testing.assert_array_equal(np.flatnonzero(run.log["status"]), [500, 501, 2500])


def test_a_real_failure_is_answered_with_the_safe_torque_and_counted(
    simulator: MujocoSimulator, controller: Controller
) -> None:
    class Contradictory(Stub):
        """Asks for feet that carry more than any torque can."""

        def command(self) -> Command:
            command = super().command()
            command["limits.torque"] = 1.0
            command["limits.acceleration"] = 0.1
            command["left_foot.minimum_force"] = 5000.0
            return command

    run = simulator.run(Contradictory(controller, lambda number, tick: None), SQUAT, laps=2)
    assert run.fell
    assert sum(run.failures.values()) == run.ticks
    assert "infeasible" in run.failures
    assert set(run.failures) <= {"infeasible", "iteration_limit"}
    assert np.isfinite(run.log["tau"]).all()


@pytest.mark.parametrize(
    "changes", [{"robot": "another"}, {"joints": ("a", "b")}], ids=["name", "joints"]
)
def test_another_robots_controller_is_refused(
    simulator: MujocoSimulator, controller: Controller, changes: dict[str, Any]
) -> None:
    stub = limp(controller)
    stub.format = replace(controller.format, **changes)
    with pytest.raises(SimulationError, match="the simulation is of 'hermes_lower'"):
        simulator.run(stub, SQUAT)
    assert stub.ticks == 0


@pytest.mark.parametrize("axes", [("com.x",), ("other.z",), ("com.z", "com.x"), ()])
def test_a_feedforward_for_other_axes_is_refused(
    simulator: MujocoSimulator, controller: Controller, axes: tuple[str, ...]
) -> None:
    stub = limp(controller)
    with pytest.raises(SimulationError, match=re.escape("the motion moves com.z")):
        simulator.run(stub, SQUAT, feedforward=Feedforward.zero(axes, PeriodicBasis()))
    assert stub.ticks == 0


@pytest.mark.parametrize(
    ("motion", "settings", "field"),
    [
        (Squat(5.0, 0.25), {}, "amplitude"),
        (Squat(0.01, 3.0), {}, "frequency"),
        (Squat(0.01, 1.0, 0.5), {}, "height"),
        (SQUAT, {"laps": 1}, "laps"),
        (SQUAT, {"laps": 0}, "laps"),
    ],
)
def test_settings_out_of_range_are_refused_before_the_first_tick(
    simulator: MujocoSimulator,
    controller: Controller,
    motion: Squat,
    settings: dict[str, Any],
    field: str,
) -> None:
    stub = limp(controller)
    with pytest.raises(InvalidValue) as caught:
        simulator.run(stub, motion, **settings)
    assert caught.value.field == field
    assert stub.ticks == 0


def test_a_controllers_error_is_passed_on(
    simulator: MujocoSimulator, controller: Controller
) -> None:
    def refuse(number: int, tick: Tick) -> None:
        if number == 10:
            raise InvalidValue("q[3]", float("nan"), "a number")

    stub = Stub(controller, refuse)
    with pytest.raises(InvalidValue, match=r"q\[3\]"):
        simulator.run(stub, SQUAT)
    assert stub.ticks == 10


def test_a_simulation_that_blows_up_is_not_silently_started_again(
    robot: Robot, controller: Controller, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes MUJOCO_LOG.TXT here

    class BlowUp(Disturbance):
        def apply(self, data: Any, state_map: StateMap, time: float) -> None:
            if time > 0.2995:
                data.qvel[8] = 1e12

    run = MujocoSimulator(robot).run(controller, SQUAT, laps=2, disturbances=[BlowUp()])
    assert run.fell
    assert run.ticks <= 302


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf, 101.0])
def test_factors_on_gains_out_of_range_are_refused(factor: float) -> None:
    for make, field in (
        (lambda: Gains(P=factor), "p scale"),
        (lambda: Gains(D=factor), "d scale"),
        (lambda: Gains.critical(factor), "p scale"),
    ):
        with pytest.raises(InvalidValue) as caught:
            make()
        assert caught.value.field == field


def test_critical_gains_keep_the_damping_ratio() -> None:
    gains = Gains.critical(4.0)
    assert (gains.P, gains.D) == (4.0, 2.0)


def test_a_fallen_run_does_not_look_perfect(fallen: Run) -> None:
    assert fallen.rms_error != 0.0


def test_it_says_how_it_differs_from_the_robot(robot: Robot) -> None:
    assert repr(MujocoSimulator(robot, 0.1, ["lag"])) == (
        "<MujocoSimulator of hermes_lower: model error 0.1, by link 0; hardware lag>"
    )
