"""One repetition while it is under way, tick by tick: in lock-step, or against the clock."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.phase_oscillator import PhaseOscillator
from tsd_casadi.encoding.steadiness import first_steady_lap, steady_from
from tsd_casadi.exceptions import SimulationError
from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.hold import hold
from tsd_casadi.motions.motion import Motion, Reference
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.observer import Observer
from tsd_casadi.repetition.pace import Pace, Periods
from tsd_casadi.repetition.phasing import PhasedShare, settling_time
from tsd_casadi.repetition.plant import Plant, Truth
from tsd_casadi.repetition.references import References
from tsd_casadi.repetition.run import Run
from tsd_casadi.repetition.tick_log import NO_STATUS, TickLog
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.format import Status
from tsd_casadi.tick.missed import Cause, Missed
from tsd_casadi.tick.row_state import AT_LIMIT
from tsd_casadi.tick.tick import Tick

HOLD = 1.0  # s
LAP_COLUMNS = ("phase", "feedback", "error", "reference", "feedforward")
# laps added beyond those asked for while the feedback has not settled
EXTRA_LAPS = 12
# of the home height of the centre of mass
FALL_HEIGHT = 0.6
FLIGHT_HEIGHT = 2.0
BLOWN_UP = 1e3  # norm of v: no robot, but a simulation that became unstable

Progress = Callable[[float, float], None]


class Repetition:
    """One repetition while it is under way: hold, move in laps, finish."""

    def __init__(
        self,
        plant: Plant,
        controller: WholeBodyController,
        motion: Motion,
        learned: tuple[str, ...],
        feedforward: Feedforward | None,
        gains: Gains,
        compensators: Sequence[Compensator],
        observers: Sequence[Observer],
        pace: Pace | None = None,
    ) -> None:
        """Prepare; nothing moves yet.

        Args:
            learned: Names 'task.axis' of the learned axes.
            pace: Against the clock; by default the plant waits for every answer.

        Raises:
            SimulationError: If controller and plant are of different robots.
            UnknownField: If no task has one of the axes.
        """
        robot, tick_format = plant.robot, controller.format
        if tick_format.robot != robot.name or tick_format.joints != tuple(robot.joint_names):
            raise SimulationError(
                f"the controller serves robot '{tick_format.robot}', the plant is a "
                f"'{robot.name}'; start both with the same --robot"
            )
        self._robot, self._plant, self._controller = robot, plant, controller
        self._motion = motion
        self._moved = motion.axes(robot)
        axes = (*learned, *(axis for axis in self._moved if axis not in learned))
        self._learned = len(learned)
        self._units = [unit_of_axis(axis) for axis in learned]
        self._places = np.array([axes.index(axis) for axis in self._moved], dtype=int)
        self._all_move = axes == self._moved
        self._feedforward = (
            Feedforward.zero(learned, PeriodicBasis())
            if feedforward is None
            else feedforward.over(learned)
        )
        self._command = controller.command()
        self._command["period"] = plant.period
        # asked for until there was one: it takes the time of a few ticks
        self._command["explain"] = 1.0
        hold(self._command, robot, motion.middle(robot))
        for task in dict.fromkeys(axis.rpartition(".")[0] for axis in learned):
            # an unknown task is told by References, with those that there are
            gains.scale(self._command, task)
        self._references = References(robot, tick_format, self._command, axes)
        self._oscillator = PhaseOscillator(motion.frequency, motion.start_phase)
        self._fall_height = FALL_HEIGHT * float(robot.home_com[2])
        self._flight_height = FLIGHT_HEIGHT * float(robot.home_com[2])
        self._log = TickLog()
        self._laps: list[Lap] = []
        # nothing need not be phased in
        self._share = PhasedShare(0.0 if self._feedforward.weights.any() else 1.0)
        self._share.go_to(1.0, 0.0, 1 / motion.frequency)
        # the newest tick in which more or less of the term was in use than before, by its time,
        # and the laps that the loop's answer to such changes is in
        self._last_share, self._changed, self._unsettled = self._share.at(0.0), 0.0, 0
        self.over = False
        self._fell = False
        self._first_steady: int | None = None
        self._infeasible_request: Vector | None = None
        self._conflict: dict[str, float] = {}
        # where nobody tells the truth
        self._model, self._data = robot.model, robot.model.createData()
        self._periods = None if pace is None else Periods(controller, robot, plant.period, pace)
        ask = controller if self._periods is None else self._periods
        self._ask: Callable[[State, Command], Tick | Missed] = ask.tick
        self._compensators, self._observers = compensators, (self._log, *observers)
        self.setting = Setting(
            robot=robot,
            controller=controller,
            motion=motion,
            axes=axes,
            learned=self._learned,
            index=self._references.index,
            period=plant.period,
        )
        self._log.start(self.setting)
        for compensator in compensators:
            compensator.start(self.setting)
        self._settling = settling_time(*(self.setting.gain(self._command, each) for each in "PD"))

    def end(self, observer: Observer) -> None:
        """Tell an observer that it is over, and how it ended."""
        steady = self._first_steady is not None
        outcome = "fell" if self._fell else "steady" if steady else "never steady"
        observer.end(outcome if self.over else "aborted")

    @property
    def ticks(self) -> int:
        """How many periods there were."""
        return self._log.ticks

    @property
    def _time(self) -> float:
        return self._plant.period * self._log.ticks

    def hold(self, progress: Progress | None) -> None:
        """Stand in the middle of the motion; the feedforward is that of the starting phase.

        It is being phased in, over the first lap's time from here on.
        """
        ticks = round(HOLD / self._plant.period)
        still = self._resting()
        feedforward = self._along(self._feedforward.mean([self._motion.start_phase]))[:, 0]
        tick = 0
        while tick < ticks:
            tick += self._tick(-1, still, feedforward)
            if progress is not None and tick % 200 == 0:
                progress(self._time, 2 * HOLD)
            if self._fell:
                return

    def move(self, laps: int, progress: Progress | None) -> None:
        """Do whole laps until they are steady."""
        period = 1 / self._motion.frequency
        bound = laps + EXTRA_LAPS
        while not self._fell and len(self._laps) < bound:
            self._lap()
            done = len(self._laps)
            if progress is not None:
                progress(HOLD + done * period, HOLD + max(laps, done) * period)
            if done >= laps:
                skipped = self._skipped
                first = steady_from(self._laps[skipped:], self._units, is_last_chance=done == bound)
                if first is not None:
                    self._first_steady = first + skipped
                    return

    def finish(self, settings: dict[str, Any], aborted: str = "") -> Run:
        """Measure and pack up.

        Args:
            aborted: What ended it early; empty for nothing.
        """
        first = None
        if len(self._laps) >= 2 and not self._fell:
            first = self._first_steady
            if first is None:
                # what was ended early may have been steady before
                first = first_steady_lap(self._laps[self._skipped :], self._units)
                first = None if first is None else first + self._skipped
            first = len(self._laps) - 2 if first is None else first
        log = self._log.log(first)
        statuses = Counter(log["status"].tolist())
        causes = Counter(log["missed"].tolist())
        vetoes = [item.veto for item in self._compensators if item.veto is not None]
        remarks = [remark for item in self._compensators for remark in item.remarks]
        feedforward = self._feedforward
        if vetoes:
            feedforward = Feedforward.zero(feedforward.axes, feedforward.basis)
        return Run(
            robot=self._robot.name,
            motion=self._motion,
            axes=self.setting.axes,
            feedforward=feedforward,
            gains={
                name: self.setting.gain(self._command, name)[: self._learned].tolist()
                for name in ("P", "D")
            },
            settings=settings,
            log=log,
            laps=[] if first is None else self._laps[first:],
            laps_run=len(self._laps),
            steady=self._first_steady is not None,
            fell=self._fell,
            vetoes=vetoes,
            remarks=remarks,
            failures={
                Status(status).name.lower(): count
                for status, count in statuses.items()
                if status not in (Status.OK, NO_STATUS)
            },
            missed={cause.words: causes[cause] for cause in Cause if causes[cause]},
            aborted=aborted,
            model=self._robot.fingerprint,
            infeasible_request=self._infeasible_request,
            at_limits=self._at_limits(log["joint_limits"]),
            conflict=self._conflict,
        )

    def _at_limits(self, joint_limits: Vector) -> dict[str, int]:
        counts = np.isin(np.abs(joint_limits), AT_LIMIT).sum(axis=0)
        joints = zip(self._controller.format.joints, counts.tolist(), strict=True)
        return {joint: count for joint, count in joints if count}

    @property
    def _skipped(self) -> int:
        """Count the laps before those with all of the feedforward, or with none.

        The last of them is not counted: it takes the place of the very first lap, which
        never is steady.
        """
        return max(self._unsettled - 1, 0)

    def _along(self, learned: Vector) -> Vector:
        """Values of the learned axes as values of all axes, zero along the others."""
        rest = np.zeros((len(self.setting.axes) - self._learned, learned.shape[1]))
        return np.concatenate((learned, rest))

    def _resting(self) -> Reference:
        nothing = np.zeros(len(self.setting.axes))
        return Reference(nothing, nothing, nothing)

    def _lap(self) -> None:
        start, began = self._log.ticks, self._time
        lap, step = self._oscillator.lap, self._oscillator.omega * self._plant.period
        # the whole lap's feedforward at once: a matrix product, not 4000
        count = math.ceil(2 * np.pi / step) + 1
        ahead = self._oscillator.phase + step * np.arange(count)
        feedforward = self._along(self._feedforward.mean(ahead))
        tick = 0
        while self._oscillator.lap == lap and not self._fell:
            if self._tick(lap, self._reference(), feedforward[:, tick]):
                self._oscillator.advance(self._plant.period)
                tick += 1
        if not self._fell:
            rows, k = self._log.columns(start, LAP_COLUMNS), self._learned
            if self._periods is not None:
                answered = self._log.columns(start, ["missed"])["missed"] == 0
                rows = {name: values[answered] for name, values in rows.items()}
            done = Lap(
                phase=rows["phase"],
                feedback=rows["feedback"].T[:k],
                error=rows["error"].T[:k],
                reference=rows["reference"].T[:k],
                feedforward=rows["feedforward"].T[:k],
            )
            self._laps.append(done)
            if self._changed + self._settling > began:
                self._unsettled = len(self._laps)
            for observer in self._observers:
                observer.lap(done)

    def _reference(self) -> Reference:
        """Positions and velocities each at the time to which the measured ones belong."""
        omega, elapsed, plant = self._oscillator.omega, self._oscillator.elapsed, self._plant
        here = self._motion.reference(elapsed + omega * plant.position_time)
        there = (
            here
            if plant.velocity_time == plant.position_time
            else self._motion.reference(elapsed + omega * plant.velocity_time)
        )
        if self._all_move:
            return Reference(here.x, there.xd, here.xdd)
        x, xd, xdd = np.zeros((3, len(self.setting.axes)))
        x[self._places], xd[self._places], xdd[self._places] = here.x, there.xd, here.xdd
        return Reference(x, xd, xdd)

    def _tick(self, lap: int, reference: Reference, feedforward: Vector) -> bool:
        """Do one period; says whether it was answered, otherwise the motion waits where it is."""
        plant, time, periods = self._plant, self._time, self._periods
        if periods is not None:
            periods.begin()
        state, truth = plant.measure(), plant.truth()
        if not self._stands(state if truth is None else truth.state, truth):
            self._fell = True
            return False
        moment = Moment(
            time,
            self._oscillator.phase,
            lap,
            state,
            reference,
            feedforward,
            self._command,
            offered=feedforward,
        )
        moment.truth = truth
        moment.share = self._share.at(time)
        moment.feedforward = moment.share * feedforward
        for compensator in self._compensators:
            compensator.before(moment)
        if moment.share != self._last_share:
            self._last_share, self._changed = moment.share, time
        self._references.write(reference.x, reference.xd, reference.xdd, moment.feedforward)
        moment.true_error = (
            np.full(len(self.setting.axes), np.nan)
            if truth is None
            else self._references.errors(truth.state, truth.com)
        )
        if self._compensators and (moment.shift.any() or moment.shift_rate.any()):
            self._references.shift(moment.shift, moment.shift_rate)
        before = perf_counter()
        answer = self._ask(state, self._command)
        moment.tick_time = 1e6 * (perf_counter() - before)
        if isinstance(answer, Missed):
            assert periods is not None
            moment.missed, moment.tau = answer, periods.hold(state)
            for observer in self._observers:
                observer.missed(moment)
            plant.apply(moment.tau)
            return False
        if answer.reply[0] == Status.INFEASIBLE and self._infeasible_request is None:
            self._infeasible_request = self._command.request.copy()
            self._conflict, self._command["explain"] = answer.conflict, 0.0
        moment.tick = answer
        moment.tau = answer.tau
        if self._compensators:
            self._ask_after(moment)
        if periods is not None:
            moment.tau = periods.resume(moment.tau)
        for observer in self._observers:
            observer.tick(moment)
        plant.apply(moment.tau)
        return True

    def _stands(self, state: State, truth: Truth | None) -> bool:
        """Whether the robot is on its feet, as measured unless somebody knows; NaN is a fall."""
        if not float(state.v @ state.v) < BLOWN_UP**2:
            return False
        com = (
            pinocchio.centerOfMass(self._model, self._data, state.q) if truth is None else truth.com
        )
        return bool(self._fall_height < com[2] < self._flight_height)

    def _ask_after(self, moment: Moment) -> None:
        """Ask the compensators; no motor gives more than its limit."""
        # a copy: the tick's answer stays what the controller said
        moment.tau = moment.tau.copy()
        for compensator in self._compensators:
            compensator.after(moment)
        limit = self._robot.torque_limit
        moment.tau = np.clip(moment.tau, -limit, limit)
