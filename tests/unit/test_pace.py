"""A repetition against a clock that goes only where somebody waits, with a controller to order."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tsd_casadi import Command, InverseDynamics, Robot, Run, State, Tick, repeat
from tsd_casadi.exceptions import ControllerSilent, InvalidValue
from tsd_casadi.repetition.compensator import Moment
from tsd_casadi.repetition.observer import Glimpses
from tsd_casadi.repetition.pace import Pace
from tsd_casadi.repetition.tick_log import NO_STATUS
from tsd_casadi.repetition.torque_blend import LARGEST_STEP
from tsd_casadi.state import Vector
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.missed import Cause, Missed


def _beside(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


plants = _beside("test_any_plant")
SQUAT, PERIOD = plants.SQUAT, plants.PERIOD


class Clock:
    """Moves only when somebody waits for it, or takes his time."""

    def __init__(self) -> None:
        self.time = 100.0

    def now(self) -> float:
        return self.time

    def sleep_until(self, moment: float) -> None:
        self.time = max(self.time, moment)


class Flat:
    """A fallback that is easily recognised."""

    def __init__(self, n: int) -> None:
        self.tau = np.full(n, -0.25)
        self.latched: list[State] = []
        self.watched = 0

    def watch(self, tau: Vector) -> None:
        self.watched += 1

    def latch(self, state: State) -> None:
        self.latched.append(state)

    def torque(self, state: State) -> Vector:
        return self.tau


class Moody(plants.Desired):  # type: ignore[name-defined, misc]
    """Answers in time but for some numbers of questions, each with what comes instead."""

    def __init__(
        self, robot: Robot, tick_format: TickFormat, moods: Callable[[int], Missed | None]
    ) -> None:
        super().__init__(robot, tick_format)
        self.moods, self.asked = moods, 0
        self.allowed: list[float] = []

    def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
        self.asked += 1
        self.allowed.append(seconds)
        return self.moods(self.asked) or self.tick(state, command)


@pytest.fixture(scope="module")
def tick_format(problem: InverseDynamics) -> TickFormat:
    return problem.format


def gap(first: int, count: int, cause: Cause = Cause.LATE) -> Callable[[int], Missed | None]:
    return lambda asked: Missed(cause, "why") if first <= asked < first + count else None


def run_with(
    robot: Robot,
    controller: object,
    *,
    clock: Clock | None = None,
    fallback: Flat | None = None,
    patience: float = 10.0,
    factor: float = 1.0,
    **options: object,
) -> Run:
    pace = Pace(factor, patience, fallback or Flat(robot.n), clock or Clock())
    return repeat(plants.Mass(robot), controller, SQUAT, pace=pace, **options)  # type: ignore[arg-type]


def test_without_a_missing_answer_it_is_the_same_as_in_lock_step(
    robot: Robot, tick_format: TickFormat
) -> None:
    paced = run_with(robot, Moody(robot, tick_format, lambda asked: None))
    waiting = repeat(plants.Mass(robot), plants.Desired(robot, tick_format), SQUAT)
    assert paced.missed == waiting.missed == {}
    assert paced.settings["pace"] == 1.0 and "pace" not in waiting.settings
    for name in ("error", "tau", "phase"):
        np.testing.assert_array_equal(paced.log[name], waiting.log[name])


@pytest.mark.parametrize("cause", list(Cause))
def test_every_cause_is_counted_logged_and_told(
    robot: Robot, tick_format: TickFormat, cause: Cause
) -> None:
    told: list[str] = []

    class Listener(Glimpses):
        def missed(self, moment: Moment) -> None:
            assert moment.tick is None
            told.append(str(moment.missed))

    controller = Moody(robot, tick_format, gap(300, 7, cause))
    run = run_with(robot, controller, observers=[Listener()])
    assert run.missed == {cause.words: 7} == run.summary()["missed"]
    assert run.failures == {}
    assert told == [f"{cause.words}: why"] * 7
    log = run.log
    np.testing.assert_array_equal(np.flatnonzero(log["missed"]), np.arange(299, 306))
    assert (log["missed"][299:306] == cause).all()
    assert (log["status"][299:306] == NO_STATUS).all()
    assert np.isnan(log["feedback"][299:306]).all() and not np.isnan(log["feedback"][306:]).any()
    # the motion waits: nothing of it is missing in its laps
    assert len(set(log["phase"][298:307])) == 2
    assert not log["measured"][299:306].any()
    assert run.steady and not np.isnan(run.rank)


def test_fallback_is_latched_once_a_gap_and_torques_do_not_step(
    robot: Robot, tick_format: TickFormat
) -> None:
    fallback = Flat(robot.n)
    moods = {number: Missed(Cause.LATE) for number in (*range(250, 260), *range(280, 283))}
    run = run_with(robot, Moody(robot, tick_format, moods.get), fallback=fallback)
    assert len(fallback.latched) == 2
    np.testing.assert_allclose(fallback.latched[0].q, run.log["q"][249], atol=1e-6)
    assert fallback.watched == run.ticks - 13
    steps = np.abs(np.diff(run.log["tau"][248:300], axis=0)) / robot.torque_limit
    assert steps.max() <= LARGEST_STEP + 1e-6
    np.testing.assert_allclose(run.log["tau"][255], -0.25)


def test_each_period_is_due_a_period_after_it_began(robot: Robot, tick_format: TickFormat) -> None:
    clock, begins = Clock(), []

    class Slow(Moody):
        def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
            begins.append(clock.now())
            clock.time += 0.4 * PERIOD  # within its half speed
            return super().tick_within(state, command, seconds)

    controller = Slow(robot, tick_format, lambda asked: None)
    run = run_with(robot, controller, clock=clock, factor=0.5)
    assert run.missed == {}
    np.testing.assert_allclose(np.diff(begins), 2 * PERIOD)
    np.testing.assert_allclose(controller.allowed, 2 * PERIOD)


def test_who_is_behind_is_not_asked_until_the_periods_are_made_up(
    robot: Robot, tick_format: TickFormat
) -> None:
    clock = Clock()

    class Stalled(Moody):
        def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
            if self.asked == 220:
                clock.time += 10.5 * PERIOD  # all of this computer stood still
                self.asked += 1
                return Missed(Cause.LATE)
            return super().tick_within(state, command, seconds)

    run = run_with(robot, Stalled(robot, tick_format, lambda asked: None), clock=clock)
    # the one that was asked, nine that were over before, and the half that is left is used
    assert run.missed == {"late": 10}


def test_an_answer_that_this_process_takes_too_late_is_not_applied(
    robot: Robot, tick_format: TickFormat
) -> None:
    clock = Clock()

    class Overslept(Moody):
        def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
            answer = super().tick_within(state, command, seconds)
            if self.asked in (220, 240):
                # to the deadline, and beyond it by as little as there is
                clock.time += seconds if self.asked == 220 else np.nextafter(seconds, 1.0) + 1e-9
            return answer

    run = run_with(robot, Overslept(robot, tick_format, lambda asked: None), clock=clock)
    assert run.missed == {"late": 1}
    np.testing.assert_array_equal(np.flatnonzero(run.log["missed"]), [239])


def test_a_controller_in_this_process_is_late_too(robot: Robot, tick_format: TickFormat) -> None:
    clock = Clock()

    class Slow(plants.Desired):  # type: ignore[name-defined, misc]
        def tick(self, state: State, command: Command) -> Tick:
            tick = super().tick(state, command)
            if self.ticks == 210:
                clock.time += 1.5 * PERIOD
            if self.ticks == 220:
                raise InvalidValue("q", "nan", "a number")
            return tick

    fallback = Flat(robot.n)
    run = run_with(robot, Slow(robot, tick_format), clock=clock, fallback=fallback)
    assert run.missed == {"late": 1, "refused": 1}


def test_patience_ends_the_run_and_what_was_run_is_kept(
    robot: Robot, tick_format: TickFormat
) -> None:
    kept: list[Run] = []
    controller = Moody(robot, tick_format, gap(300, 10**9, Cause.NOTHING_THERE))
    with pytest.raises(ControllerSilent, match=r"0\.5 s \(nothing there: why\)"):
        run_with(robot, controller, patience=0.5, on_abort=kept.append)
    (run,) = kept
    assert "nothing there" in run.aborted and not run.steady
    assert run.missed == {"nothing there": pytest.approx(0.5 / PERIOD, abs=1)}
    assert run.ticks == 299 + run.missed["nothing there"]
    assert run.summary()["aborted"] == run.aborted
    assert "aborted after" in repr(run)


def test_a_controller_that_never_answers_leaves_a_run_without_numbers(
    robot: Robot, tick_format: TickFormat
) -> None:
    kept: list[Run] = []
    with pytest.raises(ControllerSilent):
        run_with(
            robot,
            Moody(robot, tick_format, gap(0, 10**9)),
            patience=0.1,
            on_abort=kept.append,
        )
    summary = kept[0].summary()
    assert summary["rank"] is None and summary["tick_us"]["p50"] is None


@pytest.mark.parametrize("factor", [0.0, -1.0, 0.009, 10.1, np.nan, np.inf])
def test_what_is_no_pace_is_refused(factor: float) -> None:
    with pytest.raises(InvalidValue, match="pace"):
        Pace(factor)


@pytest.mark.parametrize("factor", [0.01, 10.0])
def test_slowest_and_fastest_pace(factor: float) -> None:
    assert Pace(factor, patience=np.inf).factor == factor


@pytest.mark.parametrize("patience", [0.0, -1.0, np.nan])
def test_no_patience_at_all_is_refused(patience: float) -> None:
    with pytest.raises(InvalidValue, match="patience"):
        Pace(1.0, patience)


class Distant(Moody):
    """Answers after a while, or not within the time that is left."""

    def __init__(
        self, robot: Robot, tick_format: TickFormat, clock: Clock, seconds: Callable[[int], float]
    ) -> None:
        super().__init__(robot, tick_format, lambda asked: None)
        self.clock, self.seconds = clock, seconds

    def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
        answer = super().tick_within(state, command, seconds)
        takes = self.seconds(self.asked)
        self.clock.time += min(takes, seconds)
        return answer if takes <= seconds else Missed(Cause.LATE, "not there")


class Still(Flat):
    """Slows the point down and bears what is constant."""

    def torque(self, state: State) -> Vector:
        self.tau[:3] = -20.0 * state.v[:3] - np.array([0.1, -0.2, 0.5]) / 0.9
        return self.tau


class SlowMass(plants.Mass):  # type: ignore[name-defined, misc]
    """A simulation that takes a while for each step."""

    def __init__(self, robot: Robot, clock: Clock, seconds: float) -> None:
        super().__init__(robot)
        self.clock, self.seconds = clock, seconds

    def apply(self, tau: Vector) -> None:
        self.clock.time += self.seconds
        super().apply(tau)


@pytest.mark.parametrize(
    ("answers", "steps", "most"), [(0.70, 0.32, 0.15), (0.70, 0.29, 0.01), (0.90, 0.30, 0.55)]
)
def test_one_late_period_does_not_make_all_others_late(
    robot: Robot, tick_format: TickFormat, answers: float, steps: float, most: float
) -> None:
    clock = Clock()
    # once something else is in the way; then both together take just more than a period
    controller = Distant(
        robot, tick_format, clock, lambda asked: PERIOD * (2.0 if asked == 300 else answers)
    )
    # what holds it up while it is not answered
    pace = Pace(1.0, 10.0, Still(robot.n), clock)
    run = repeat(SlowMass(robot, clock, steps * PERIOD), controller, SQUAT, pace=pace)
    assert not run.fell and set(run.missed) == {"late"}
    assert run.missed["late"] <= most * run.ticks


def test_answers_that_became_slower_are_still_asked_for(
    robot: Robot, tick_format: TickFormat
) -> None:
    # quick at first: what is usual follows; then as slow as a period allows
    clock = Clock()
    controller = Distant(
        robot, tick_format, clock, lambda asked: PERIOD * (0.1 if asked < 300 else 0.99)
    )
    pace = Pace(1.0, 10.0, Flat(robot.n), clock)
    run = repeat(SlowMass(robot, clock, 0.0), controller, SQUAT, pace=pace)
    assert not run.missed


def test_where_nobody_is_every_period_asks(robot: Robot, tick_format: TickFormat) -> None:
    clock = Clock()
    controller = Moody(robot, tick_format, gap(300, 50, Cause.NOTHING_THERE))
    pace = Pace(1.0, 10.0, Still(robot.n), clock)
    run = repeat(SlowMass(robot, clock, 0.9 * PERIOD), controller, SQUAT, pace=pace)
    assert run.missed == {"nothing there": 50}
