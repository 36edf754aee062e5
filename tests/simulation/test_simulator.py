from __future__ import annotations

import json
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
from tsd_casadi.encoding.steadiness import first_steady_lap
from tsd_casadi.exceptions import InvalidValue, ParityError, RobotFileError, SimulationError
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.motions.circle import Circle
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.sway import Sway
from tsd_casadi.motions.twist import Twist
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.repetition.repetition import EXTRA_LAPS, HOLD
from tsd_casadi.tick.format import Status, TickFormat
from tsd_clients import MujocoSimulator
from tsd_clients.logs.log_file import save_log
from tsd_clients.simulator.disturbances import Disturbance, Push
from tsd_clients.simulator.effects import EFFECTS
from tsd_clients.simulator.simulator import START_NOISE
from tsd_clients.simulator.state_map import StateMap

SQUAT = Squat(amplitude=0.01, frequency=1.0)
AXES = ("com.z",)
TIMESTEP = 1e-3  # s
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


def z(run: Run) -> AxisError:
    """How the vertical axis was tracked."""
    return run.errors["com.z"]


@pytest.fixture(scope="module")
def a_feedforward() -> Feedforward:
    basis = PeriodicBasis()
    phase = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    weights = basis.fit(phase, -0.7 - 0.05 * np.sin(phase + 0.5)[None, :])
    return Feedforward(("com.z",), basis, weights, np.zeros_like(weights), "learned")


@pytest.fixture(scope="module")
def run(simulator: MujocoSimulator, controller: Controller) -> Run:
    return simulator.run(controller, SQUAT, axes=AXES, laps=2)


@pytest.fixture(scope="module")
def fed_run(simulator: MujocoSimulator, controller: Controller, a_feedforward: Feedforward) -> Run:
    return simulator.run(
        controller, SQUAT, axes=AXES, laps=2, feedforward=a_feedforward, gains=Gains(P=0.5)
    )


@pytest.fixture(scope="module")
def fallen(simulator: MujocoSimulator, controller: Controller) -> Run:
    return simulator.run(limp(controller), SQUAT, axes=AXES, laps=2)


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
    with pytest.raises(ParityError, match=r"body torso: mass is 22\.85 kg"):
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
    state = simulator.near(robot.home, seed=4)
    offset = state.q[7:] - robot.home.q[7:]
    assert 0.5 * START_NOISE < np.abs(offset).max() <= START_NOISE
    assert not state.v.any()
    np.testing.assert_array_equal(state.q[[0, 1, 3, 4, 5, 6]], robot.home.q[[0, 1, 3, 4, 5, 6]])
    heights = [robot.frame_placement(sole, state.q)[0][2] for sole in ("L_sole", "R_sole")]
    assert np.mean(heights) == pytest.approx(0, abs=1e-12)


def test_start_depends_on_the_seed_only(simulator: MujocoSimulator, robot: Robot) -> None:
    one, again, other = (simulator.near(robot.home, seed).q for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    assert np.abs(one - other).max() > 1e-5


# a run


def test_squats_about_another_height(simulator: MujocoSimulator, controller: Controller) -> None:
    run = simulator.run(controller, Squat(0.01, 1.0, height=0.05), laps=2)
    assert run.steady
    assert run.failures == {}
    # the robot, not only the reference, is up there
    middle = simulator.robot.home_com[2] + 0.05
    height = middle + run.along("reference", "com.z") - run.along("true_error", "com.z")
    assert height[run.log["measured"]].mean() == pytest.approx(middle, abs=0.03)
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
    # feet that are believed flat and start tilted by milliradians slap down: of eight seeds
    # two let the robot fall (three without limits of joint positions); this is none of them
    run = MujocoSimulator(robot, 0.1, [effect]).run(controller, SQUAT, laps=2, seed=1)
    assert (run.steady, run.fell, run.failures) == (True, False, {})
    assert run.settings["hardware"] == [effect]
    without = MujocoSimulator(robot, 0.1).run(controller, SQUAT, laps=2, seed=1)
    assert z(run).rms != z(without).rms
    assert z(run).rms == pytest.approx(z(without).rms, rel=0.5)


@pytest.fixture(scope="module")
def hard_run(robot: Robot, controller: Controller) -> Run:
    simulator = MujocoSimulator(robot, 0.1, ["all"])
    return simulator.run(controller, Squat(0.02, 0.5), laps=2)


def test_all_hardware_together_is_steady(hard_run: Run) -> None:
    assert (hard_run.steady, hard_run.fell, hard_run.failures) == (True, False, {})
    assert hard_run.settings["hardware"] == list(EFFECTS)
    # feet on a rigid floor: the sensors are good enough to know the robot's error by
    assert z(hard_run).true_rms == pytest.approx(z(hard_run).rms, rel=0.01)


def test_hardware_leaves_an_error_that_changes_within_a_lap(
    robot: Robot, controller: Controller, hard_run: Run
) -> None:
    # friction turns with the velocity, an offset does not
    bodies = MujocoSimulator(robot, 0.1).run(controller, Squat(0.02, 0.5), laps=2)
    one, other = (z(each).ac_rms for each in (hard_run, bodies))
    assert one is not None
    assert other is not None
    assert one > 5 * other


def test_the_records_keep_the_true_state_and_the_command(
    hard_run: Run, robot: Robot, controller: Controller
) -> None:
    assert (np.abs(hard_run.log["tau"]) <= robot.torque_limit).all()
    data = robot.model.createData()
    tick = hard_run.ticks // 2
    com = pinocchio.centerOfMass(robot.model, data, hard_run.log["q"][tick].astype(float))
    place = hard_run.log["reference"][tick] - hard_run.log["true_error"][tick]
    np.testing.assert_allclose((com - robot.home_com)[[2, 0, 1]], place, atol=1e-6)


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
    pushed = simulator.run(controller, SQUAT, axes=AXES, laps=3, disturbances=[push])
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
    again = simulator.run(controller, SQUAT, axes=AXES, laps=2)
    for name, values in run.log.items():
        if name not in TIMES:
            np.testing.assert_array_equal(again.log[name], values, err_msg=name)
    assert again.errors == run.errors


def test_runs_with_different_seeds_differ_a_little(
    simulator: MujocoSimulator, controller: Controller, run: Run
) -> None:
    other = simulator.run(controller, SQUAT, laps=2, seed=1)
    assert np.abs(other.log["q"][0] - run.log["q"][0]).max() > 1e-5
    assert z(other).rms != z(run).rms
    assert z(other).rms == pytest.approx(z(run).rms, rel=0.02)


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


def test_reference_is_the_motion_about_its_middle(run: Run) -> None:
    elapsed = run.log["phase"] - np.pi
    assert (elapsed[:HOLD_TICKS] == 0).all()
    expected = np.array([SQUAT.reference(e).x for e in elapsed])
    np.testing.assert_allclose(run.log["reference"], expected, atol=1e-12)
    np.testing.assert_allclose(
        elapsed[HOLD_TICKS:], 2 * np.pi * TIMESTEP * np.arange(run.ticks - HOLD_TICKS), atol=1e-9
    )


def test_log_is_documented_and_complete(run: Run) -> None:
    n, contacts = run.log["tau"].shape[1], run.log["wrenches"].shape[1] // 6
    axes = run.log["all_errors"].shape[1]
    shapes = {
        "()": (),
        "(k,)": (1,),
        "(a,)": (axes,),
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
        expected = robot.home_com[2] + run.log["reference"][tick, 0] - height
        assert run.log["true_error"][tick, 0] == pytest.approx(expected, abs=1e-6)


def test_a_uniform_model_error_leaves_the_centre_of_mass_where_it_is(run: Run) -> None:
    # so what the controller sees is the truth, at the same instant
    np.testing.assert_allclose(run.log["error"], run.log["true_error"], atol=1e-9)


def test_feedback_is_p_times_error_plus_d_times_its_rate(run: Run) -> None:
    (P,), (D,) = run.gains["P"], run.gains["D"]
    error, feedback = run.along("error", "com.z"), run.along("feedback", "com.z")
    expected = P * error + D * np.gradient(error, TIMESTEP)
    late = slice(HOLD_TICKS + LAP_TICKS, run.ticks - 1)
    np.testing.assert_allclose(feedback[late], expected[late], atol=0.01)
    assert np.std(feedback[late]) > 0.01  # there was something to compare


def phased_in(run: Run) -> np.ndarray:
    """How much of the feedforward is in use: level at both ends of the first lap's time."""
    laps = np.minimum(run.log["time"] * run.motion.frequency, 1.0)
    return 3 * laps**2 - 2 * laps**3


def test_feedforward_is_that_of_the_phase_and_constant_while_holding(
    fed_run: Run, run: Run, a_feedforward: Feedforward
) -> None:
    assert not run.log["feedforward"].any()
    share = phased_in(fed_run)
    expected = a_feedforward.mean(fed_run.log["phase"]).T * share[:, None]
    np.testing.assert_allclose(fed_run.log["feedforward"], expected, atol=1e-12)
    start = a_feedforward.mean([np.pi])[0, 0] * share[:HOLD_TICKS]
    np.testing.assert_allclose(fed_run.log["feedforward"][:HOLD_TICKS, 0], start, atol=1e-12)
    assert np.ptp(fed_run.log["feedforward"]) > 0.05


def test_a_factor_on_p_multiplies_p_and_only_p(
    fed_run: Run, run: Run, controller: Controller
) -> None:
    for field in ("P", "D"):
        default = controller.command()[f"com.{field}"][2]
        assert run.gains[field] == [default]
        factor = 0.5 if field == "P" else 1.0
        assert fed_run.gains[field] == [factor * default]


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
    assert z(fed_run).rms < 0.2 * z(run).rms


def test_settings_and_feedforward_are_kept(
    simulator: MujocoSimulator, fed_run: Run, a_feedforward: Feedforward
) -> None:
    assert fed_run.settings == {
        "model_error": 0.1,
        "hardware": [],
        "period_s": 1e-3,
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
    error, true, feedback = (
        run.along(name, "com.z")[measured] for name in ("error", "true_error", "feedback")
    )
    found = z(run)
    assert found.rms == pytest.approx(np.sqrt((error**2).mean()))
    assert found.ac_rms == pytest.approx(error.std())
    assert found.peak == np.abs(error).max()
    assert found.true_rms == pytest.approx(np.sqrt((true**2).mean()))
    assert found.mean_abs_feedback == pytest.approx(np.abs(feedback).mean())


def test_measured_are_exactly_the_steady_laps(run: Run) -> None:
    log = run.log
    whole = [(log["phase"][log["lap"] == n], log["feedback"][log["lap"] == n]) for n in range(9)]
    kept = whole[run.laps_run - len(run.laps) : run.laps_run]
    assert 2 <= len(run.laps) <= run.laps_run
    for lap, (phase, feedback) in zip(run.laps, kept, strict=True):
        np.testing.assert_array_equal(lap.phase, phase)
        np.testing.assert_array_equal(lap.feedback, feedback.T)
    assert log["measured"].sum() == len(run.laps) * LAP_TICKS
    assert log["measured"][-len(run.laps) * LAP_TICKS :].all()
    # the very first lap of a repetition never counts
    assert first_steady_lap([run.laps[0], *run.laps], ["m"] * len(run.learned)) == 1


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
    assert z(run).rms > 0


# what goes wrong


def test_a_robot_without_torque_falls_and_is_reported(fallen: Run, robot: Robot) -> None:
    assert fallen.fell
    assert not fallen.steady
    assert (fallen.laps, fallen.laps_run, fallen.failures) == ([], 0, {})
    assert 100 < fallen.ticks < HOLD_TICKS  # it takes its time, then the run ends
    assert not fallen.log["measured"].any()
    height = robot.home_com[2] - fallen.along("true_error", "com.z")
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
    assert summary["fell_at"] == fallen.log["time"][-1]
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
    with pytest.raises(SimulationError, match="the plant is a 'hermes_lower'"):
        simulator.run(stub, SQUAT)
    assert stub.ticks == 0


@pytest.mark.parametrize("known", [("com.x",), ("com.y", "com.z", "torso.rz")])
def test_a_feedforward_of_other_axes_is_zero_where_it_knows_nothing(
    simulator: MujocoSimulator, controller: Controller, known: tuple[str, ...]
) -> None:
    basis = PeriodicBasis()
    weights = np.full((len(known), basis.L), 0.25)
    given = Feedforward(known, basis, weights, np.zeros_like(weights), "learned")
    axes = ("com.x", "com.z")
    run = simulator.run(limp(controller), SQUAT, axes=axes, feedforward=given)
    for axis in axes:
        expected = (0.25 if axis in known else 0.0) * phased_in(run)
        np.testing.assert_allclose(run.along("feedforward", axis), expected, atol=1e-12)
    assert run.feedforward.axes == axes


@pytest.mark.parametrize(
    ("motion", "settings", "field"),
    [
        (Squat(5.0, 0.25), {}, "amplitude"),
        (Squat(0.01, 3.0), {}, "frequency"),
        (Squat(0.01, 1.0, 0.5), {}, "height"),
        (SQUAT, {"laps": 1}, "laps"),
        (SQUAT, {"laps": 0}, "laps"),
        (SQUAT, {"axes": ()}, "axes"),
        (SQUAT, {"axes": ("com.z", "com.x", "com.z")}, "axes"),
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
    assert np.isnan(z(fallen).rms)
    assert np.isnan(fallen.rank)


def test_it_says_how_it_differs_from_the_robot(robot: Robot) -> None:
    assert repr(MujocoSimulator(robot, 0.1, ["lag"])) == (
        "<MujocoSimulator of hermes_lower: model error 0.1, by link 0; hardware lag>"
    )


# when positions and velocities are measured


def test_a_perfect_model_is_tracked_to_a_few_micrometres(
    robot: Robot, controller: Controller
) -> None:
    run = MujocoSimulator(robot).run(controller, Squat(0.03, 0.25), laps=2)
    assert z(run).rms < 2e-6


def test_velocities_are_said_to_be_half_a_step_older(robot: Robot) -> None:
    simulator = MujocoSimulator(robot)
    assert (simulator.position_time, simulator.velocity_time) == (0.0, -TIMESTEP / 2)
    # what that means: a velocity is the last step's difference of positions
    simulator.start(robot.home, seed=1)
    states = []
    for _ in range(50):
        states.append(simulator.measure())
        simulator.apply(np.zeros(robot.n))
    moved = (states[-1].q[7:] - states[-2].q[7:]) / TIMESTEP
    np.testing.assert_allclose(moved, states[-1].v[6:], atol=1e-9)
    assert np.abs(moved).max() > 0.1


# several axes, translations and rotations


@pytest.mark.parametrize("motion", [Sway(0.03, 0.5), Circle(0.02, 0.5), Twist(0.15, 0.5), SQUAT])
def test_what_the_controller_sees_of_a_perfect_model_is_the_truth(
    robot: Robot, controller: Controller, motion: Motion
) -> None:
    """Errors of every axis, of the centre of mass and of frames."""
    every = tuple(".".join(pair) for pair in controller.format.axes)
    axes = (*motion.axes(robot), *(axis for axis in every if axis not in motion.axes(robot)))
    run = MujocoSimulator(robot).run(controller, motion, axes=axes, laps=2)
    assert (run.steady, run.failures) == (True, {})
    assert run.log["error"].shape == (run.ticks, 9)
    np.testing.assert_allclose(run.log["true_error"], run.log["error"], atol=1e-9)
    for axis in motion.axes(robot):
        # it moves, and is followed
        assert np.ptp(run.along("reference", axis)) > 0.015
        assert run.errors[axis].rms < 1e-3


def test_a_twist_turns_the_torso_about_the_worlds_vertical(
    robot: Robot, controller: Controller
) -> None:
    run = MujocoSimulator(robot).run(controller, Twist(0.15, 0.5), axes=("torso.rz",), laps=2)
    frame = next(task.frame for task in robot.description.tasks if task.name == "torso")
    home = pinocchio.Quaternion(robot.frame_placement(frame, robot.home.q)[1]).matrix()
    for tick in range(HOLD_TICKS, run.ticks, 500):
        q = run.log["q"][tick].astype(float)
        turned = pinocchio.Quaternion(robot.frame_placement(frame, q)[1]).matrix() @ home.T
        expected = run.along("reference", "torso.rz")[tick] - run.along("error", "torso.rz")[tick]
        assert pinocchio.log3(turned)[2] == pytest.approx(expected, abs=1e-5)


# the control period


@pytest.mark.parametrize(
    ("period", "step"), [(5e-3, 1e-3), (1e-3, 1e-3), (0.25e-3, 0.25e-3), (1.5e-3, 0.75e-3)]
)
def test_the_control_period_is_a_setting_and_the_simulation_steps_finer(
    robot: Robot, controller: Controller, period: float, step: float
) -> None:
    simulator = MujocoSimulator(robot, 0.1, period=period)
    assert simulator.model.opt.timestep == pytest.approx(step, rel=1e-12)
    assert simulator.velocity_time == pytest.approx(-step / 2, rel=1e-12)
    run = simulator.run(controller, SQUAT, axes=AXES, laps=2)
    assert (run.steady, run.fell, run.failures) == (True, False, {})
    assert run.settings["period_s"] == period
    np.testing.assert_allclose(np.diff(run.log["time"]), period, rtol=1e-6)
    assert (run.log["lap"] == -1).sum() == round(HOLD / period)
    assert (run.log["lap"] == 0).sum() == pytest.approx(1 / period, abs=1)
    # the same robot, whoever asks how often
    assert z(run).rms == pytest.approx(0.0150, rel=0.02)


@pytest.mark.parametrize("period", [5e-3, 0.25e-3])
def test_hardware_runs_at_the_simulations_step(
    robot: Robot, controller: Controller, period: float
) -> None:
    usual, other = (
        MujocoSimulator(robot, 0.1, ["all"], period=each).run(controller, SQUAT, axes=AXES, laps=2)
        for each in (1e-3, period)
    )
    assert (other.steady, other.fell, other.failures) == (True, False, {})
    assert z(other).rms == pytest.approx(z(usual).rms, rel=0.05)


def test_encoders_sample_every_step_of_a_longer_period(robot: Robot) -> None:
    """Differenced over a step, not over the controller's period as if it were one."""
    simulator = MujocoSimulator(robot, hardware=["differencing"], period=5e-3)
    simulator.start(robot.home, seed=1)
    for _ in range(40):
        measured = simulator.measure()
        simulator.apply(np.zeros(robot.n))
    truth = simulator.truth()
    assert truth is not None
    # falling freely: the filter is behind by its time constant times the acceleration
    speed = np.abs(truth.state.v[6:]).max()
    assert speed > 0.5
    assert np.abs(measured.v[6:] - truth.state.v[6:]).max() < 0.1 * speed


@pytest.mark.parametrize("period", [0.0, -1e-3, 0.24e-3, 5.1e-3, 1.0, np.nan, np.inf])
def test_a_period_out_of_range_is_refused(robot: Robot, period: float) -> None:
    with pytest.raises(InvalidValue, match=r"period is .*expected 0\.00025 to 0\.005 s"):
        MujocoSimulator(robot, period=period)
