"""One repetition in lock-step: simulator and controller, tick by tick."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from time import perf_counter
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.command import Command
from tsd_casadi.controller import WholeBodyController
from tsd_casadi.exceptions import SimulationError
from tsd_casadi.feedforward import Feedforward
from tsd_casadi.laps import Lap, first_steady_lap
from tsd_casadi.motions import Motion
from tsd_casadi.periodic_basis import PeriodicBasis
from tsd_casadi.phase_oscillator import PhaseOscillator
from tsd_casadi.robot import Robot
from tsd_casadi.tick_format import Status
from tsd_clients.mujoco_state import StateMap
from tsd_clients.run import Run

TIMESTEP = 1e-3  # s
HOLD = 1.0  # s
# laps added beyond those asked for while the feedback has not settled
EXTRA_LAPS = 12
# of the home height of the centre of mass
FALL_HEIGHT = 0.6
FLIGHT_HEIGHT = 2.0
BLOWN_UP = 1e3  # m/s, rad/s: no robot, but a simulation that became unstable

COLUMNS = (
    "time",
    "phase",
    "lap",
    "reference",
    "error",
    "true_error",
    "feedback",
    "feedforward",
    "all_errors",
    "q",
    "v",
    "tau",
    "wrenches",
    "status",
    "compute_us",
    "tick_us",
)
SINGLE_PRECISION = ("all_errors", "q", "v", "tau", "wrenches")

Progress = Callable[[float, float], None]


class Repetition:
    """One run while it is under way: hold, move in laps, finish."""

    def __init__(
        self,
        robot: Robot,
        model: Any,
        data: Any,
        controller: WholeBodyController,
        motion: Motion,
        feedforward: Feedforward | None,
        p_scale: float,
    ) -> None:
        """Prepare a run.

        Args:
            robot: The robot.
            model: ``mujoco.MjModel``.
            data: ``mujoco.MjData`` at the start.
            controller: Local or remote.
            motion: What to do.
            feedforward: Learned term, or none.
            p_scale: Factor on the learned task's P.

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
        self._model = model
        self._data = data
        self._state_map = StateMap(robot, model)
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
        self._command: Command = controller.command()
        self._command[f"{self._task}.P"] *= p_scale
        # views into the request vector
        self._x = self._command[f"{self._task}.reference"]
        self._xd = self._command[f"{self._task}.reference_velocity"]
        self._xdd = self._command[f"{self._task}.reference_acceleration"]
        self._ff = self._command[f"{self._task}.feedforward"]
        self._home = float(self._x[self._world_axis])
        self._oscillator = PhaseOscillator(motion.frequency, motion.start_phase)
        self._fall_height = FALL_HEIGHT * float(robot.home_com[2])
        self._flight_height = FLIGHT_HEIGHT * float(robot.home_com[2])
        self._columns: dict[str, list[Any]] = {name: [] for name in COLUMNS}
        self._laps: list[Lap] = []
        self._lap_starts: list[int] = []
        self._fell = False
        self._steady = False

    @property
    def _time(self) -> float:
        return TIMESTEP * len(self._columns["time"])

    def hold(self, progress: Progress | None) -> None:
        """Stand at home; the feedforward is that of the starting phase."""
        ticks = round(HOLD / TIMESTEP)
        feedforward = float(self._feedforward.mean([self._motion.start_phase])[0, 0])
        for tick in range(ticks):
            self._tick(-1, 0.0, 0.0, 0.0, feedforward)
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
            if done >= laps and first_steady_lap(self._laps) is not None:
                self._steady = True
                return

    def finish(self, settings: dict[str, Any]) -> Run:
        """Measure and pack up."""
        log = {name: np.array(values) for name, values in self._columns.items()}
        first = first_steady_lap(self._laps)
        measured = np.zeros(len(log["time"]), dtype=bool)
        laps: list[Lap] = []
        if len(self._laps) >= 2 and not self._fell:
            first = len(self._laps) - 2 if first is None else first
            laps = self._laps[first:]
            measured[self._lap_starts[first] :] = True
        log["measured"] = measured
        for name in SINGLE_PRECISION:
            log[name] = log[name].astype(np.float32)
        statuses = Counter(int(status) for status in log["status"])
        return Run(
            robot=self._robot.name,
            motion=self._motion,
            feedforward=self._feedforward,
            gains={
                field: self._command[f"{self._task}.{field}"].tolist() for field in ("P", "D", "W")
            },
            settings=settings,
            log=log,
            laps=laps,
            laps_run=len(self._laps),
            steady=self._steady,
            fell=self._fell,
            failures={
                Status(status).name.lower(): count
                for status, count in statuses.items()
                if status != Status.OK
            },
        )

    def _lap(self) -> None:
        start = len(self._columns["time"])
        lap, step = self._oscillator.lap, self._oscillator.omega * TIMESTEP
        # the whole lap's feedforward at once: a matrix product, not 4000
        count = int(2 * np.pi / step) + 2
        ahead = self._oscillator.phase + step * np.arange(count)
        feedforward = self._feedforward.mean(ahead)[0]
        tick = 0
        while self._oscillator.lap == lap and not self._fell:
            reference = self._motion.reference(self._oscillator.elapsed)
            self._tick(lap, reference.x, reference.xd, reference.xdd, float(feedforward[tick]))
            self._oscillator.advance(TIMESTEP)
            tick += 1
        if not self._fell:
            self._lap_starts.append(start)
            self._laps.append(
                Lap(
                    np.array(self._columns["phase"][start:]),
                    np.array(self._columns["feedback"][start:])[None, :],
                )
            )

    def _tick(self, lap: int, x: float, xd: float, xdd: float, feedforward: float) -> None:
        axis, data, state_map = self._component, self._data, self._state_map
        self._x[self._world_axis] = self._home + x
        self._xd[axis], self._xdd[axis], self._ff[axis] = xd, xdd, feedforward
        # positions and velocities first, so that the true centre of mass is the
        # one of the state that the controller is asked about
        mujoco.mj_step1(self._model, data)
        state = state_map.read(data)
        com = data.subtree_com[state_map.base_body]
        # NaN is a fall as well
        stands = self._fall_height < com[2] < self._flight_height
        if not (stands and np.abs(state.v).max() < BLOWN_UP):
            self._fell = True
            return
        before = perf_counter()
        tick = self._controller.tick(state, self._command)
        after = perf_counter()
        error, feedback = tick.error, tick.feedback
        values = (
            self._time,
            self._oscillator.phase,
            lap,
            self._home + x,
            error[self._axis],
            self._home + x - com[self._world_axis],
            feedback[self._axis],
            feedforward,
            error,
            state.q,
            state.v,
            tick.tau,
            tick.reply[self._wrenches],
            int(tick.reply[0]),
            tick.compute_time,
            1e6 * (after - before),
        )
        for column, value in zip(self._columns.values(), values, strict=True):
            column.append(value)
        data.ctrl[state_map.actuators] = tick.tau
        mujoco.mj_step2(self._model, data)
