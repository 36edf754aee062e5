"""One repetition in lock-step: simulator and controller, tick by tick."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.encoding.laps import first_steady_lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.phase_oscillator import PhaseOscillator
from tsd_casadi.exceptions import SimulationError
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.hold import hold
from tsd_casadi.motions.motion import Motion, Reference
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.plant import Plant
from tsd_casadi.repetition.run import Run
from tsd_casadi.repetition.tick_log import TickLog
from tsd_casadi.robot.robot import Robot
from tsd_casadi.tick.format import Status

HOLD = 1.0  # s
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
        robot: Robot,
        plant: Plant,
        controller: WholeBodyController,
        motion: Motion,
        feedforward: Feedforward | None,
        gains: Gains,
        compensators: Sequence[Compensator],
    ) -> None:
        """Prepare a repetition.

        Args:
            plant: The robot at its start.
            feedforward: Learned term, or none.
            gains: Factors on the learned task's gains.

        Raises:
            SimulationError: If controller or feedforward are for something else.
        """
        tick_format = controller.format
        if tick_format.robot != robot.name or tick_format.joints != tuple(robot.joint_names):
            raise SimulationError(
                f"the controller serves robot '{tick_format.robot}', the simulation is of "
                f"'{robot.name}'; start both with the same --robot"
            )
        self._robot = robot
        self._plant = plant
        self._controller = controller
        self._motion = motion
        self._task = motion.task(robot)
        axis = f"{self._task}.{motion.axis}"
        self._feedforward = feedforward or Feedforward.zero((axis,), PeriodicBasis())
        if self._feedforward.axes != (axis,):
            raise SimulationError(
                f"the feedforward is for {', '.join(self._feedforward.axes)}, the motion "
                f"moves {axis}"
            )
        self._axis = tick_format.axis_index(self._task, motion.axis)
        self._component = tick_format.component_index(self._task, motion.axis)
        self._world_axis = "xyz".index(motion.axis)
        self._wrenches = tick_format.reply.slice("wrenches")
        self._command = controller.command()
        hold(self._command, robot, motion.middle(robot))
        self._command[f"{self._task}.P"] *= gains.P
        self._command[f"{self._task}.D"] *= gains.D
        # views into the request vector
        self._x = self._command[f"{self._task}.reference"]
        self._xd = self._command[f"{self._task}.reference_velocity"]
        self._xdd = self._command[f"{self._task}.reference_acceleration"]
        self._ff = self._command[f"{self._task}.feedforward"]
        self._middle = self._x.copy()
        # world axes that the task controls, in its order
        axes = [name for task, name in tick_format.axes if task == self._task]
        self._moved = np.array(["xyz".index(name) for name in axes])
        self._oscillator = PhaseOscillator(motion.frequency, motion.start_phase)
        self._fall_height = FALL_HEIGHT * float(robot.home_com[2])
        self._flight_height = FLIGHT_HEIGHT * float(robot.home_com[2])
        self._log = TickLog()
        self._fell = False
        self._steady = False
        self._compensators = compensators
        setting = Setting(
            robot=robot,
            controller=controller,
            task=self._task,
            component=self._component,
            axis=self._axis,
            dt=plant.period,
        )
        for compensator in compensators:
            compensator.start(setting)

    @property
    def _time(self) -> float:
        return self._plant.period * len(self._log)

    def hold(self, progress: Progress | None) -> None:
        """Stand in the middle of the motion; the feedforward is that of the starting phase."""
        ticks = round(HOLD / self._plant.period)
        feedforward = float(self._feedforward.mean([self._motion.start_phase])[0, 0])
        for tick in range(ticks):
            self._tick(-1, Reference(0.0, 0.0, 0.0), feedforward)
            if progress is not None and tick % 200 == 0:
                progress(self._time, 2 * HOLD)
            if self._fell:
                return

    def move(self, laps: int, progress: Progress | None) -> None:
        """Do whole laps until they are steady."""
        period = 1 / self._motion.frequency
        bound = laps + EXTRA_LAPS
        while not self._fell and len(self._log.laps) < bound:
            self._lap()
            done = len(self._log.laps)
            if progress is not None:
                progress(HOLD + done * period, HOLD + max(laps, done) * period)
            if done >= laps and first_steady_lap(self._log.laps) is not None:
                self._steady = True
                return

    def finish(self, settings: dict[str, Any]) -> Run:
        """Measure and pack up."""
        first, laps = (len(self._log), []) if self._fell else self._log.measured_laps()
        log = self._log.arrays(measured_from=first)
        statuses = Counter(int(status) for status in log["status"])
        return Run(
            robot=self._robot.name,
            motion=self._motion,
            feedforward=self._feedforward_in_the_end(),
            gains={
                field: self._command[f"{self._task}.{field}"].tolist() for field in ("P", "D", "W")
            },
            settings=settings,
            log=log,
            laps=laps,
            laps_run=len(self._log.laps),
            steady=self._steady,
            fell=self._fell,
            failures={
                Status(status).name.lower(): count
                for status, count in statuses.items()
                if status != Status.OK
            },
        )

    def _feedforward_in_the_end(self) -> Feedforward:
        """Tell the one of the measured laps, none if the gate dropped it."""
        feedforward = self._feedforward
        gates = [item for item in self._compensators if isinstance(item, FeedforwardGate)]
        if any(gate.dropped_at is not None for gate in gates):
            return Feedforward.zero(feedforward.axes, feedforward.basis)
        return feedforward

    def _lap(self) -> None:
        start = len(self._log)
        lap, step = self._oscillator.lap, self._oscillator.omega * self._plant.period
        # the whole lap's feedforward at once: a matrix product, not 4000
        count = int(2 * np.pi / step) + 2
        ahead = self._oscillator.phase + step * np.arange(count)
        feedforward = self._feedforward.mean(ahead)[0]
        tick = 0
        while self._oscillator.lap == lap and not self._fell:
            reference = self._motion.reference(self._oscillator.elapsed)
            self._tick(lap, reference, float(feedforward[tick]))
            self._oscillator.advance(self._plant.period)
            tick += 1
        if not self._fell:
            self._log.add_lap(start)

    def _tick(self, lap: int, reference: Reference, feedforward: float) -> None:
        plant, axis, time = self._plant, self._world_axis, self._time
        true, state = plant.measure()
        com = plant.com
        # NaN is a fall as well
        stands = self._fall_height < com[2] < self._flight_height
        if not (stands and true.v @ true.v < BLOWN_UP**2):
            self._fell = True
            return
        moment = Moment(
            time, self._oscillator.phase, lap, state, reference, feedforward, self._command
        )
        for compensator in self._compensators:
            compensator.before(moment)
        self._write(moment)
        before = perf_counter()
        tick = self._controller.tick(state, self._command)
        after = perf_counter()
        moment.tick, moment.tau = tick, tick.tau
        if self._compensators:
            self._correct_torque(moment)
        wanted = self._middle[axis] + reference.x
        error = tick.error
        self._log.add(
            time,
            moment.phase,
            lap,
            wanted,
            error[self._axis],
            wanted - com[axis],
            tick.feedback[self._axis],
            moment.feedforward,
            error,
            true.q,
            true.v,
            moment.tau,
            tick.reply[self._wrenches],
            int(tick.reply[0]),
            tick.compute_time,
            1e6 * (after - before),
        )
        plant.step(moment.tau, time)

    def _correct_torque(self, moment: Moment) -> None:
        """Ask the compensators; no motor gives more than its limit."""
        # a copy: the tick's answer stays what the controller said
        moment.tau = moment.tau.copy()
        for compensator in self._compensators:
            compensator.after(moment)
        limit = self._robot.torque_limit
        moment.tau = np.clip(moment.tau, -limit, limit)

    def _write(self, moment: Moment) -> None:
        """Write reference, feedforward and compensators into the command."""
        component, reference = self._component, moment.reference
        np.add(self._middle, moment.shift, out=self._x)
        self._x[self._world_axis] += reference.x
        np.take(moment.shift_rate, self._moved, out=self._xd)
        self._xd[component] += reference.xd
        self._xdd[component], self._ff[component] = reference.xdd, moment.feedforward
