"""The loop on a plant without a simulator and without a robot's dynamics.

A rigid whole that does not turn: three of its "joint torques" are what the
controller believes to be the acceleration of its centre of mass.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tsd_casadi import (
    Command,
    Feedforward,
    InverseDynamics,
    PeriodicBasis,
    Plant,
    Robot,
    Run,
    Squat,
    State,
    Tick,
    Truth,
    learn,
    repeat,
)
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.exceptions import (
    EntryNotFound,
    InvalidValue,
    ServiceUnreachable,
    SimulationError,
    UnknownField,
)
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.motions.circle import Circle
from tsd_casadi.motions.twist import Twist
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.observer import Glimpses
from tsd_casadi.repetition.repetition import HOLD
from tsd_casadi.state import Vector
from tsd_casadi.tick.format import Status, TickFormat

PERIOD = 5e-3
SQUAT = Squat(0.02, 1.0)
CIRCLE = Circle(0.02, 1.0)
COM = ("com.x", "com.y", "com.z")
HOLD_TICKS, LAP_TICKS = round(HOLD / PERIOD), round(1 / PERIOD)


class Mass(Plant):
    """A point whose acceleration is a share of what was asked for, and something constant.

    Semi-implicit, at 200 Hz: velocities are half a period older than positions.
    """

    def __init__(
        self,
        robot: Robot,
        share: float = 0.9,
        bias: tuple[float, float, float] = (0.1, -0.2, 0.5),
        tells: bool = True,
    ) -> None:
        self.robot, self.period, self.velocity_time = robot, PERIOD, -0.5 * PERIOD
        self.share, self.bias, self.tells = share, np.array(bias), tells
        self.started: list[tuple[State, int]] = []
        self.applied: list[Vector] = []

    def start(self, posture: State, seed: int = 0) -> None:
        self.started.append((posture, seed))
        self.q, self.v = posture.q.copy(), posture.v.copy()
        # off by a little, as whatever stands on feet is
        self.q[:3] += 1e-3 * np.random.default_rng(seed).uniform(-1, 1, 3)

    def measure(self) -> State:
        return State(self.q.copy(), self.v.copy())

    def apply(self, tau: Vector) -> None:
        self.applied.append(tau.copy())
        self.v[:3] += self.period * (self.share * tau[:3] + self.bias)
        self.q[:3] += self.period * self.v[:3]

    def truth(self) -> Truth | None:
        if not self.tells:
            return None
        return Truth(self.measure(), self.robot.center_of_mass(self.q))

    def settings(self) -> dict[str, Any]:
        return {"share": self.share}


class Desired:
    """A controller whose first three torques are the desired acceleration, eq. des_cart_acc."""

    def __init__(self, robot: Robot, tick_format: TickFormat) -> None:
        self.robot, self.format = robot, tick_format
        self.ticks = 0

    def command(self) -> Command:
        return Command(self.format.request)

    def tick(self, state: State, command: Command) -> Tick:
        self.ticks += 1
        tick = Tick(self.format, np.zeros(self.format.reply.size))
        P, D, x, xd, xdd, u = (
            command[f"com.{field}"]
            for field in (
                "P",
                "D",
                "reference",
                "reference_velocity",
                "reference_acceleration",
                "feedforward",
            )
        )
        tick.error[:3] = x - self.robot.center_of_mass(state.q)
        tick.feedback[:3] = P * tick.error[:3] + D * (xd - state.v[:3])
        tick.tau[:3] = xdd + tick.feedback[:3] + u
        return tick


class Memory:
    """A learner that keeps entries in a dictionary."""

    def __init__(self) -> None:
        self.entries: dict[EntryKey, Entry] = {}
        self.asked: list[dict[str, Any]] = []
        self.recorded: list[Recording] = []

    def query(self, motion: str, /, **asked: Any) -> Feedforward:
        self.asked.append({"motion": motion, **asked})
        for key, entry in self.entries.items():
            if (key.motion, key.axes) == (motion, tuple(asked["axes"])):
                return entry.feedforward()
        raise EntryNotFound("nothing")

    def record(self, recording: Recording, instruction: Instruction) -> tuple[Any, list[str]]:
        self.recorded.append(recording)
        entry = self.entries.get(recording.key)
        if entry is None:
            entry = Entry(recording.key, recording.basis, recording.circumstances)
            self.entries[recording.key] = entry
        notes = entry.add(recording, instruction)
        return type("Learned", (), {"contractions": ()}), notes


class Diary:
    """Notes everything that it is told of."""

    def __init__(self, name: str = "one", calls: list[Any] | None = None) -> None:
        self.name, self.calls = name, [] if calls is None else calls
        self.laps: list[Lap] = []

    def start(self, setting: Setting) -> None:
        self.calls.append((self.name, "start", setting.axes))

    def tick(self, moment: Moment) -> None:
        assert moment.tick is not None
        self.calls.append((self.name, "tick", moment.time))

    def lap(self, lap: Lap) -> None:
        self.laps.append(lap)
        self.calls.append((self.name, "lap", len(self.laps)))

    def end(self, outcome: str) -> None:
        self.calls.append((self.name, "end", outcome))


@pytest.fixture
def plant(robot: Robot) -> Mass:
    return Mass(robot)


@pytest.fixture
def controller(robot: Robot, problem: InverseDynamics) -> Desired:
    return Desired(robot, problem.format)


def constant(axes: tuple[str, ...], *values: float) -> Feedforward:
    basis = PeriodicBasis()
    weights = np.repeat(np.array(values)[:, None], basis.L, axis=1)
    return Feedforward(axes, basis, weights, np.zeros_like(weights), "learned")


# one repetition


def test_measures_are_those_of_the_plant(plant: Mass, controller: Desired) -> None:
    run = repeat(plant, controller, SQUAT)
    assert (run.steady, run.fell, run.failures, run.vetoes) == (True, False, {}, [])
    # all of the centre of mass, what moves first
    assert run.axes == run.learned == ("com.z", "com.x", "com.y")
    assert run.settings == {
        "share": 0.9,
        "period_s": PERIOD,
        "p_scale": 1.0,
        "d_scale": 1.0,
        "transport": "local",
        "seed": 0,
    }
    # standing still: P e = -bias / share along what does not move
    for axis, bias in (("com.x", 0.1), ("com.y", -0.2)):
        error = run.errors[axis]
        assert error.rms == pytest.approx(abs(bias) / 0.9 / run.gains["P"][1], rel=1e-3)
        assert error.true_rms == pytest.approx(error.rms, rel=1e-9)
        assert error.ac_rms == pytest.approx(0, abs=1e-6)
    assert run.errors["com.z"].ac_rms > 1e-4
    P, errors = np.array(run.gains["P"]), run.errors.values()
    assert run.rank == pytest.approx(
        np.sqrt(np.mean([(p * e.rms) ** 2 for p, e in zip(P, errors, strict=True)]))
    )


def test_the_plant_is_started_at_the_motions_middle_and_gets_every_torque(
    plant: Mass, controller: Desired
) -> None:
    run = repeat(plant, controller, Squat(0.02, 1.0, height=0.03), seed=7)
    ((posture, seed),) = plant.started
    assert seed == 7
    raised = plant.robot.center_of_mass(posture.q)[2] - plant.robot.home_com[2]
    assert raised == pytest.approx(0.03, abs=1e-9)
    assert len(plant.applied) == controller.ticks == run.ticks
    np.testing.assert_array_equal(np.array(plant.applied, dtype=np.float32), run.log["tau"])


def test_the_period_is_the_plants(plant: Mass, controller: Desired) -> None:
    run = repeat(plant, controller, SQUAT, laps=2)
    np.testing.assert_allclose(np.diff(run.log["time"]), PERIOD, rtol=1e-9)
    assert (run.log["lap"] == -1).sum() == HOLD_TICKS
    for lap in range(run.laps_run):
        assert (run.log["lap"] == lap).sum() == LAP_TICKS


@pytest.mark.parametrize("motion", [SQUAT, CIRCLE])
def test_a_perfect_model_is_tracked_where_the_plant_says_when(
    robot: Robot, controller: Desired, motion: Any
) -> None:
    """References are evaluated at the times to which positions and velocities belong."""
    perfect = Mass(robot, share=1.0, bias=(0.0, 0.0, 0.0))
    told = repeat(perfect, controller, motion, axes=COM)
    perfect.velocity_time = 0.0
    untold = repeat(perfect, controller, motion, axes=COM)
    for axis in motion.axes(robot):
        off, best = untold.errors[axis].rms, told.errors[axis].rms
        assert best < 0.1 * off
        # D (period / 2) xdd / P, nearly: the squat is fast
        amplitude = 0.02 * (2 * np.pi) ** 2 / np.sqrt(2)
        expected = untold.gains["D"][0] * PERIOD / 2 * amplitude / untold.gains["P"][0]
        assert off == pytest.approx(expected, rel=0.5)


def test_references_of_axes_that_do_not_move_are_their_middle(
    plant: Mass, controller: Desired
) -> None:
    run = repeat(plant, controller, CIRCLE, axes=("com.z", "com.y"))
    assert run.axes == ("com.z", "com.y", "com.x")
    assert run.learned == ("com.z", "com.y")
    assert not run.along("reference", "com.z").any()
    late = run.log["phase"] - CIRCLE.start_phase > np.pi
    expected = np.array([CIRCLE.offset(phase).x for phase in run.log["phase"][late]])
    names = CIRCLE.axes(plant.robot)
    for axis, wanted in zip(names, expected.T, strict=True):
        np.testing.assert_allclose(run.along("reference", axis)[late], wanted, atol=1e-12)
    assert list(run.errors) == ["com.z", "com.y"]


@pytest.mark.parametrize(
    ("axes", "error", "words"),
    [
        (("com.z", "com.z"), InvalidValue, "none twice"),
        ((), InvalidValue, "at least one axis"),
        (("com.z", "hand.x"), UnknownField, r"no field 'hand\.x'.*there are com\.x"),
        (("com.rz",), UnknownField, "no field"),
        (("z",), UnknownField, "no field 'z'"),
    ],
)
def test_axes_that_cannot_be_are_refused_before_anything_starts(
    plant: Mass, controller: Desired, axes: tuple[str, ...], error: type[Exception], words: str
) -> None:
    diary = Diary()
    with pytest.raises(error, match=words):
        repeat(plant, controller, SQUAT, axes=axes, observers=[diary])
    assert (plant.started, diary.calls, controller.ticks) == ([], [], 0)


def test_a_rotation_on_a_robot_without_that_task_is_refused_before_anything_starts(
    robot: Robot, controller: Desired, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant = Mass(robot)
    with_com = [task for task in robot.description.tasks if task.type == "com"]
    description = robot.description.model_copy(update={"all_tasks": with_com})
    monkeypatch.setattr(robot, "description", description)
    with pytest.raises(InvalidValue, match=r"a frame task with axis rz among com \(x y z\)"):
        repeat(plant, controller, Twist(0.1, 0.5))
    assert (plant.started, controller.ticks) == ([], 0)


@pytest.mark.parametrize("changes", [{"robot": "another"}, {"joints": ("a", "b")}])
def test_another_robots_controller_is_refused(
    plant: Mass, controller: Desired, changes: dict[str, Any]
) -> None:
    controller.format = replace(controller.format, **changes)
    with pytest.raises(SimulationError, match="the plant is a 'hermes_lower'"):
        repeat(plant, controller, SQUAT)
    assert plant.started == []


# falling


@pytest.mark.parametrize("tells", [True, False])
def test_a_fall_is_judged_from_what_is_measured_where_nobody_tells_the_truth(
    robot: Robot, controller: Desired, tells: bool
) -> None:
    dropped = Mass(robot, bias=(0.0, 0.0, -60.0), tells=tells)
    run = repeat(dropped, controller, SQUAT)
    assert (run.fell, run.steady, run.laps, run.laps_run) == (True, False, [], 0)
    assert 10 < run.ticks < HOLD_TICKS
    height = robot.home_com[2] - run.log["true_error"][:, 0]
    if tells:
        assert 0.6 * robot.home_com[2] < height[-1] < 0.7 * robot.home_com[2]
    else:
        assert np.isnan(run.log["true_error"]).all()
    # what is logged is the best that is known of the state
    fallen = robot.center_of_mass(run.log["q"][-1].astype(float))[2]
    assert 0.6 * robot.home_com[2] < fallen < 0.7 * robot.home_com[2]


@pytest.mark.parametrize("tells", [True, False])
def test_the_truth_counts_more_than_what_is_measured(
    robot: Robot, controller: Desired, tells: bool
) -> None:
    class Blind(Mass):
        """Believes to stand at home for ever."""

        def measure(self) -> State:
            return robot.home

        def truth(self) -> Truth | None:
            known = State(self.q.copy(), self.v.copy())
            return Truth(known, robot.center_of_mass(self.q)) if tells else None

    run = repeat(Blind(robot, bias=(0.0, 0.0, -60.0)), controller, SQUAT, axes=COM)
    assert run.fell == tells


@pytest.mark.parametrize("tells", [True, False])
def test_numbers_that_are_none_are_a_fall(robot: Robot, controller: Desired, tells: bool) -> None:
    plant = Mass(robot, tells=tells)

    class Break(Compensator):
        def after(self, moment: Moment) -> None:
            if moment.time > 0.5:
                plant.q[:] = plant.v[:] = np.nan

    run = repeat(plant, controller, SQUAT, compensators=[Break()])
    assert run.fell
    assert run.ticks == pytest.approx(0.5 / PERIOD, abs=3)


def test_what_nobody_knows_is_said_to_be_unknown(robot: Robot, controller: Desired) -> None:
    run = repeat(Mass(robot, tells=False), controller, SQUAT)
    assert run.steady
    assert [error.true_rms for error in run.errors.values()] == [None] * 3
    assert run.summary()["errors"]["com.z"]["true_rms"] is None
    assert run.errors["com.z"].rms > 0


# learning


@pytest.mark.parametrize("tells", [True, False])
@pytest.mark.parametrize("motion", [SQUAT, CIRCLE])
def test_learning_takes_every_axis_error_off(
    robot: Robot, controller: Desired, motion: Any, tells: bool
) -> None:
    memory, diary = Memory(), Diary()
    runs = learn(
        Mass(robot, tells=tells), controller, [motion], memory, iterations=2, observers=[diary]
    )
    for axis in COM:
        first, _, last = (run.errors[axis].rms for run in runs)
        assert last < 0.01 * first, axis
    assert [call[2] for call in diary.calls if call[1] == "end"] == ["steady"] * 3
    (entry,) = memory.entries.values()
    assert set(entry.key.axes) == set(COM)
    assert entry.key.context.body == robot.body_fingerprint
    # whoever is asked is told robot, axes and context, always
    for asked in memory.asked:
        assert (asked["robot"], set(asked["axes"])) == (robot.name, set(COM))
        assert asked["context"] == entry.key.context
    declared = memory.recorded[0].declaration
    assert declared == motion.declaration()


@pytest.mark.parametrize(
    ("bias", "error"),
    [
        (0.5, ServiceUnreachable("learner", ["tcp/127.0.0.1:7448"], "no reply")),
        (0.5, KeyboardInterrupt()),
        (-60.0, None),
    ],
    ids=["no learner", "Ctrl-C", "fell"],
)
def test_what_was_run_is_told_though_nobody_recorded_it(
    robot: Robot, controller: Desired, bias: float, error: BaseException | None
) -> None:
    class Forgetful(Memory):
        def record(self, recording: Recording, instruction: Instruction) -> Any:
            if error is not None and self.recorded:
                raise error
            return super().record(recording, instruction)

    told: list[Run] = []
    kept: list[Run] = []
    with pytest.raises(SimulationError if error is None else type(error)):
        learn(
            Mass(robot, bias=(0.1, -0.2, bias)),
            controller,
            [SQUAT],
            Forgetful(),
            iterations=2,
            on_run=lambda run, _: told.append(run),
            on_abort=kept.append,
        )
    (run,) = kept
    assert len(told) == (0 if error is None else 1)
    assert (run.aborted, run.fell, run.steady) == ("", error is None, error is not None)


def test_a_load_is_said_and_patience_begins_again(robot: Robot, controller: Desired) -> None:
    class Loaded(Mass):
        def start(self, posture: State, seed: int = 0) -> None:
            super().start(posture, seed)
            after = len(self.started) - 4
            if after > 0:
                # settles, and is never as well known as the robot of before was
                self.bias = (1 + 0.01 * 0.5**after) * np.array([0.1, -0.2, -0.5])

    said: list[list[str]] = []
    runs = learn(
        Loaded(robot),
        controller,
        [Squat(0.02, 0.25)],
        Memory(),
        iterations=7,
        patience=2,
        rule="guarded",
        on_run=lambda _, notes: said.append(notes),
    )
    told = [any("not the robot of before" in note for note in notes) for notes in said]
    assert told.index(True) == 4
    ranks = [run.rank for run in runs]
    # no error is smaller than the best one of the robot of before, which counts no more
    assert len(ranks) == 8
    assert 10 * min(ranks[:4]) < min(ranks[4:])
    assert ranks[4:] == sorted(ranks[4:], reverse=True)


def test_an_entry_of_fewer_axes_serves_a_run_of_more_and_it_is_said(
    plant: Mass, controller: Desired
) -> None:
    class One(Memory):
        def query(self, motion: str, /, **_: Any) -> Feedforward:
            return constant(("com.z",), -0.5)

    notes: list[str] = []
    runs = learn(
        plant, controller, [SQUAT], One(), axes=COM, on_run=lambda _, said: notes.extend(said)
    )
    assert "nothing was learned along com.x, com.y yet: zero there" in notes
    assert not runs[0].log["feedforward"][:, :2].any()
    np.testing.assert_allclose(runs[0].log["feedforward"][LAP_TICKS:, 2], -0.5)
    assert runs[0].feedforward.axes == COM


# feedforward, gate and compensators


def test_feedforward_reaches_its_axis(plant: Mass, controller: Desired) -> None:
    helps = constant(("com.y", "com.z"), 0.2 / 0.9, -0.5 / 0.9)
    without, fed = (repeat(plant, controller, SQUAT, feedforward=u) for u in (None, helps))
    assert fed.errors["com.y"].rms < 1e-3 * without.errors["com.y"].rms
    assert fed.errors["com.x"].rms == pytest.approx(without.errors["com.x"].rms, rel=1e-6)
    assert fed.errors["com.z"].rms < 0.5 * without.errors["com.z"].rms


@pytest.mark.parametrize("axes", [("com.z",), COM])
@pytest.mark.parametrize("harms", [True, False])
def test_the_gate_drops_what_harms_and_the_loop_hears_its_veto(
    plant: Mass, controller: Desired, axes: tuple[str, ...], harms: bool
) -> None:
    right = {"com.x": -0.1, "com.y": 0.2, "com.z": -0.5}
    factor = -1.0 if harms else 1.0
    borrowed = constant(axes, *(factor * right[axis] for axis in axes))
    gate = FeedforwardGate()
    run = repeat(
        plant, controller, SQUAT, axes=axes, feedforward=borrowed, compensators=[gate], laps=4
    )
    if not harms:
        assert gate.veto is None
        assert run.vetoes == []
        assert run.feedforward.kind == "learned"
        return
    assert run.vetoes == [gate.veto]
    assert "was dropped at 0." in run.vetoes[0]
    assert run.feedforward.kind == "none"
    assert run.feedforward.axes == axes
    assert not run.feedforward.weights.any()
    fed = np.abs(run.log["feedforward"]).max(axis=1)
    assert not fed[-1]
    # never more than half of it was in use
    assert 0 < fed.max() < 0.6 * np.abs(borrowed.weights).max()


class Pushed(Mass):
    """A mass that something pushes for a while."""

    def __init__(
        self, robot: Robot, start: float, duration: float, acceleration: tuple[float, float, float]
    ) -> None:
        super().__init__(robot)
        self.push, self.extra = (start, start + duration), np.array(acceleration)

    def apply(self, tau: Vector) -> None:
        time, calm = len(self.applied) * self.period, self.bias
        if self.push[0] <= time < self.push[1]:
            self.bias = calm + self.extra
        super().apply(tau)
        self.bias = calm


@pytest.mark.parametrize(
    ("duration", "push", "drops"),
    # 50 N s and 50 N on 60 kg, the latter for as long as two laps: that looks like harm
    [(0.05, (0.0, 0.0, -16.0), 1), (0.05, (0.0, 0.0, 16.0), 0), (2.0, (0.0, 0.0, -0.8), 1)],
)
def test_the_gate_forgives_a_push(
    robot: Robot,
    controller: Desired,
    duration: float,
    push: tuple[float, float, float],
    drops: int,
) -> None:
    fits = constant(COM, -0.1 / 0.9, 0.2 / 0.9, -0.5 / 0.9)
    gate = FeedforwardGate()
    calm = repeat(Mass(robot), controller, SQUAT, axes=COM, feedforward=fits)
    plant = Pushed(robot, HOLD + 2.2, duration, push)
    run = repeat(plant, controller, SQUAT, axes=COM, feedforward=fits, compensators=[gate], laps=8)
    assert gate.drops == drops
    assert gate.veto is None
    assert (run.vetoes, run.feedforward.kind) == ([], "learned")
    # all of it, two laps after the end
    back = run.log["time"] >= HOLD + 2.2 + duration + 2 / SQUAT.frequency
    np.testing.assert_allclose(run.log["feedforward"][back][:, 2], -0.5 / 0.9)
    assert run.errors["com.z"].rms == pytest.approx(calm.errors["com.z"].rms, rel=0.02)
    assert any("came back" in remark for remark in run.remarks) == (gate.drops > 0)
    assert "was kept: an RMS error of" in run.remarks[-1]


# phasing in


@pytest.mark.parametrize("frequency", [1.0, 0.4])
def test_a_term_is_phased_in_over_the_first_laps_time(
    plant: Mass, controller: Desired, frequency: float
) -> None:
    run = repeat(
        plant,
        controller,
        Squat(0.02, frequency),
        axes=("com.z",),
        feedforward=constant(("com.z",), -0.5),
    )
    fed = -2 * run.log["feedforward"][:, 0]
    ticks = round(1 / frequency / PERIOD)
    assert fed[0] == 0.0
    assert (np.diff(fed[: ticks + 1]) > 0).all()
    assert np.diff(fed).max() < 1.6 / ticks
    assert fed[ticks // 2] == pytest.approx(0.5)
    np.testing.assert_allclose(fed[ticks:], 1.0)
    np.testing.assert_allclose(run.measured("feedforward"), -0.5)
    assert run.steady


@pytest.mark.parametrize(("p_scale", "first"), [(1.0, 1), (0.1, 2)])
def test_laps_count_once_the_loop_has_answered_the_phasing_in(
    robot: Robot, controller: Desired, p_scale: float, first: int
) -> None:
    fits = constant(COM, -0.1 / 0.9, 0.2 / 0.9, -0.5 / 0.9)
    gains = Gains.critical(p_scale)
    motion = Squat(0.02, 0.5)
    run = repeat(Mass(robot), controller, motion, axes=COM, feedforward=fits, gains=gains)
    assert run.log["lap"][run.log["measured"]].min() == first
    # as if all of it had been in use from the very beginning
    before = run.errors["com.y"].rms
    assert before < 1e-3 * 0.2 / 0.9 / run.gains["P"][1]


def test_nothing_need_not_be_phased_in(plant: Mass, controller: Desired) -> None:
    seen = []

    class Look(Compensator):
        def before(self, moment: Moment) -> None:
            seen.append(moment.share)

    repeat(plant, controller, SQUAT, compensators=[Look()])
    assert set(seen) == {1.0}


def test_any_compensator_can_veto(plant: Mass, controller: Desired) -> None:
    class Cautious(Compensator):
        veto = "it is Friday"

    run = repeat(
        plant,
        controller,
        SQUAT,
        axes=("com.z",),
        feedforward=constant(("com.z",), 0.1),
        compensators=[Compensator(), Cautious()],
    )
    assert run.vetoes == ["it is Friday"]
    assert run.feedforward.kind == "none"


def test_compensators_know_axes_gains_and_period(plant: Mass, controller: Desired) -> None:
    class Look(Compensator):
        def start(self, setting: Setting) -> None:
            self.setting = setting

        def before(self, moment: Moment) -> None:
            self.P = self.setting.gain(moment.command, "P")

    look, usual = Look(), controller.command()
    usual["com.P"], usual["torso.P"] = [10.0, 20.0, 30.0], [40.0, 50.0, 60.0]
    controller.command = usual.copy  # type: ignore[method-assign]
    repeat(plant, controller, CIRCLE, axes=("torso.rz", "com.y"), compensators=[look])
    setting = look.setting
    assert (setting.robot, setting.motion, setting.period) == (plant.robot, CIRCLE, PERIOD)
    assert (setting.axes, setting.learned) == (("torso.rz", "com.y", "com.x"), 2)
    known = [".".join(pair) for pair in controller.format.axes]
    assert [known[i] for i in setting.index] == list(setting.axes)
    np.testing.assert_array_equal(look.P, [60.0, 20.0, 10.0])


# observers


def test_observers_are_told_of_everything_in_order(plant: Mass, controller: Desired) -> None:
    calls: list[Any] = []
    run = repeat(
        plant, controller, SQUAT, axes=COM, observers=[Diary("a", calls), Diary("b", calls)]
    )
    expected: list[Any] = [(name, "start", COM) for name in "ab"]
    for tick in range(run.ticks):
        expected += [(name, "tick", PERIOD * tick) for name in "ab"]
        done = tick + 1 - HOLD_TICKS
        if done > 0 and done % LAP_TICKS == 0:
            expected += [(name, "lap", done // LAP_TICKS) for name in "ab"]
    # as of things that are opened one in another
    expected += [(name, "end", "steady") for name in "ba"]
    assert calls == expected


def broken(when: str, error: BaseException) -> Diary:
    """An observer that fails at its first call of a kind."""
    diary = Diary("broken")

    def fail(*_: Any) -> None:
        raise error

    setattr(diary, when, fail)
    return diary


@pytest.mark.parametrize("when", ["start", "tick", "lap", "end"])
@pytest.mark.parametrize("error", [OSError("disk full"), KeyboardInterrupt()])
def test_whatever_an_observer_does_the_others_are_told_of_the_end(
    plant: Mass, controller: Desired, when: str, error: BaseException
) -> None:
    before, after, failing = Diary("before"), Diary("after"), broken(when, error)
    with pytest.raises(type(error)):
        repeat(plant, controller, SQUAT, observers=[before, failing, after])
    if when != "end":
        # whatever it began at its start can be put away
        assert failing.calls[-1] == ("broken", "end", "aborted")
    outcome = "steady" if when == "end" else "aborted"
    assert before.calls[-1] == ("before", "end", outcome)
    # who was never told of the start is not told of the end
    assert after.calls[-1:] == ([] if when == "start" else [("after", "end", outcome)])
    assert [call[1] for call in before.calls].count("end") == 1


@pytest.mark.parametrize(
    "stop", [lambda: (_ for _ in ()).throw(OSError("cable")), None], ids=["lost", "fell"]
)
def test_the_end_is_told_when_the_plant_is_lost_or_falls(
    robot: Robot, controller: Desired, stop: Callable[[], Any] | None
) -> None:
    plant, diary = Mass(robot), Diary()
    if stop is None:
        plant.bias[2] = -60.0
        repeat(plant, controller, SQUAT, observers=[diary])
    else:
        monkey = plant.measure

        def measure() -> State:
            return stop() if len(plant.applied) == 30 else monkey()

        plant.measure = measure  # type: ignore[method-assign]
        with pytest.raises(OSError, match="cable"):
            repeat(plant, controller, SQUAT, observers=[diary])
    assert diary.calls[-1] == ("one", "end", "fell" if stop is None else "aborted")
    assert "lap" not in [call[1] for call in diary.calls]


def test_what_never_settles_ends_so(robot: Robot, controller: Desired) -> None:
    class Drift(Compensator):
        def before(self, moment: Moment) -> None:
            moment.feedforward += 0.2 * moment.time

    diary = Diary()
    run = repeat(Mass(robot), controller, SQUAT, compensators=[Drift()], observers=[diary])
    assert not run.steady
    assert diary.calls[-1][2] == "never steady"
    assert len(run.laps) == 2


def test_laps_are_what_the_run_is_measured_by(plant: Mass, controller: Desired) -> None:
    diary = Diary()
    run = repeat(plant, controller, SQUAT, observers=[diary])
    assert run.laps == diary.laps[-len(run.laps) :]
    assert len(diary.laps) == run.laps_run


def test_glimpses_drop_the_oldest_and_count(plant: Mass, controller: Desired) -> None:
    few, many = Glimpses(100), Glimpses(10_000)
    run = repeat(plant, controller, SQUAT, observers=[few, many])
    assert few.dropped == run.ticks - 100
    newest = few.take()
    np.testing.assert_array_equal([each["time"] for each in newest], run.log["time"][-100:])
    # whoever comes in time gets all of it, and nothing twice
    assert many.dropped == 0
    taken = many.take()
    np.testing.assert_array_equal([each["time"] for each in taken], run.log["time"])
    np.testing.assert_array_equal([each["error"] for each in taken], run.log["error"])
    assert many.take() == few.take() == []


def test_the_log_loses_nothing_and_is_not_overwritten(plant: Mass, controller: Desired) -> None:
    class Recorder(Diary):
        def __init__(self) -> None:
            super().__init__()
            self.rows: list[tuple[Any, ...]] = []

        def tick(self, moment: Moment) -> None:
            assert moment.tick is not None
            self.rows.append(
                tuple(
                    np.array(values, copy=True)
                    for values in (
                        moment.reference.x,
                        moment.true_error,
                        moment.feedforward,
                        moment.tick.error,
                        moment.state.q.astype(np.float32),
                        moment.tau.astype(np.float32),
                    )
                )
            )

    recorder = Recorder()
    run = repeat(plant, controller, CIRCLE, axes=COM, observers=[recorder])
    names = ("reference", "true_error", "feedforward", "all_errors", "q", "tau")
    assert len(recorder.rows) == run.ticks == len(plant.applied)
    for name, values in zip(names, zip(*recorder.rows, strict=True), strict=True):
        np.testing.assert_array_equal(
            run.log[name], np.array(values, dtype=run.log[name].dtype), err_msg=name
        )


def test_a_run_that_failed_ticks_counts_them_by_name(plant: Mass, controller: Desired) -> None:
    class Once(Desired):
        def tick(self, state: State, command: Command) -> Tick:
            tick = super().tick(state, command)
            tick.reply[0] = Status.INFEASIBLE if self.ticks in (10, 300) else Status.OK
            return tick

    run: Run = repeat(plant, Once(plant.robot, controller.format), SQUAT)
    assert run.failures == {"infeasible": 2}
