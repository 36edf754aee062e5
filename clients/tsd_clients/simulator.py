"""A MuJoCo simulation that asks a controller for torques at every tick."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from time import perf_counter
from typing import Any

import mujoco
import numpy as np
import pinocchio

from tsd_casadi import State
from tsd_casadi.command import Command
from tsd_casadi.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue, RobotFileError, SimulationError
from tsd_casadi.feedforward import Feedforward
from tsd_casadi.laps import Lap, first_steady_lap
from tsd_casadi.motions import Motion
from tsd_casadi.periodic_basis import PeriodicBasis
from tsd_casadi.phase_oscillator import PhaseOscillator
from tsd_casadi.robot import Robot
from tsd_casadi.tick_format import Status
from tsd_clients.mujoco_state import StateMap
from tsd_clients.parity import check_parity
from tsd_clients.run import Run

TIMESTEP = 1e-3  # s
HOLD = 2.0  # s
# starting posture: joints off home by up to this [rad], as in the paper's
# simulation, which "has a small starting randomness built-in"
START_NOISE = 2e-3
# laps added beyond those asked for while the feedback has not settled
EXTRA_LAPS = 12
# of the home height of the centre of mass
FALL_HEIGHT = 0.6
FLIGHT_HEIGHT = 2.0
BLOWN_UP = 1e3  # m/s, rad/s: no robot, but a simulation that became unstable

Progress = Callable[[float, float], None]


class MujocoSimulator:
    """The simulated robot, with a body that the controller need not know.

    Attributes:
        robot: The robot as its files describe it.
        model: ``mujoco.MjModel`` with the model error applied.
        model_error: E; the controller's masses and inertias are 1 + E times
            the simulated robot's.
        state_map: Conversion between the conventions of scene and robot.
    """

    def __init__(self, robot: Robot, model_error: float = 0.0) -> None:
        """Load the scene and check it against the URDF.

        Args:
            robot: The robot.
            model_error: E, greater than -1.

        Raises:
            RobotFileError: If the scene cannot be used.
            ParityError: If scene and URDF describe different bodies.
            InvalidValue: If the model error is out of range.
        """
        if not -0.9 <= model_error <= 9.0:
            raise InvalidValue("model error", model_error, "a fraction from -0.9 to 9, 0.1 is 10 %")
        try:
            model: Any = mujoco.MjModel.from_xml_path(str(robot.scene_path))
        except ValueError as error:
            raise RobotFileError(
                robot.scene_path, "", f"cannot be loaded ({error})", "a MuJoCo scene"
            ) from error
        check_parity(robot, model)
        model.opt.timestep = TIMESTEP
        # positions, then velocities, then forces: what mj_step1 and mj_step2 do
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        # a simulation that blew up is a fall, not a new start
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        model.body_mass[:] /= 1 + model_error
        model.body_inertia[:] /= 1 + model_error
        mujoco.mj_setConst(model, mujoco.MjData(model))
        self.robot = robot
        self.model = model
        self.model_error = model_error
        self.state_map = StateMap(robot, model)

    def start(self, seed: int = 0) -> Any:
        """A fresh ``mujoco.MjData`` at home, joints off by a little.

        Args:
            seed: Of the starting randomness.
        """
        rng = np.random.default_rng(seed)
        home = self.robot.home
        q = home.q.copy()
        q[7:] += rng.uniform(-START_NOISE, START_NOISE, size=self.robot.n)
        model, pin_data = self.robot.model, self.robot.model.createData()
        pinocchio.framesForwardKinematics(model, pin_data, q)
        frames = [model.getFrameId(contact.frame) for contact in self.robot.description.contacts]
        q[2] -= np.mean([pin_data.oMf[frame].translation[2] for frame in frames])
        data = mujoco.MjData(self.model)
        self.state_map.write(data, State(q, home.v))
        mujoco.mj_forward(self.model, data)
        return data

    def run(
        self,
        controller: WholeBodyController,
        motion: Motion,
        *,
        laps: int = 3,
        feedforward: Feedforward | None = None,
        p_scale: float = 1.0,
        seed: int = 0,
        transport: str = "local",
        progress: Progress | None = None,
    ) -> Run:
        """Simulate one repetition in lock-step with a controller.

        The robot holds home for two seconds with the feedforward of the
        starting phase, then moves. Laps are added until two consecutive ones
        agree, up to a bound.

        Args:
            controller: Local or remote.
            motion: What to do.
            laps: Least number of laps.
            feedforward: Learned term; none by default.
            p_scale: Factor on the learned task's P; D stays.
            seed: Of the starting randomness.
            transport: How the controller is reached, for the records.
            progress: Called with (done, total) seconds of simulated time.

        Returns:
            The run.

        Raises:
            InvalidValue: If motion or settings are out of range.
            SimulationError: If the controller serves another robot.
        """
        motion.check(self.robot)
        if laps < 2:
            raise InvalidValue("laps", laps, "at least 2, the first one settles")
        if not 0 < p_scale <= 100:
            raise InvalidValue("p scale", p_scale, "a factor above 0, up to 100")
        repetition = _Repetition(self, controller, motion, feedforward, p_scale, seed)
        repetition.hold(progress)
        repetition.move(laps, progress)
        settings = {
            "model_error": self.model_error,
            "p_scale": p_scale,
            "transport": transport,
            "seed": seed,
        }
        return repetition.finish(settings)


class _Repetition:
    """The state of one run while it is under way."""

    def __init__(
        self,
        simulator: MujocoSimulator,
        controller: WholeBodyController,
        motion: Motion,
        feedforward: Feedforward | None,
        p_scale: float,
        seed: int,
    ) -> None:
        robot, tick_format = simulator.robot, controller.format
        if tick_format.robot != robot.name or tick_format.joints != tuple(robot.joint_names):
            raise SimulationError(
                f"the controller serves robot '{tick_format.robot}', the simulation is of "
                f"'{robot.name}'; start both with the same --robot"
            )
        self._simulator = simulator
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
        self._command: Command = controller.command()
        self._command[f"{self._task}.P"] *= p_scale
        # views into the request vector
        self._x = self._command[f"{self._task}.reference"]
        self._xd = self._command[f"{self._task}.reference_velocity"]
        self._xdd = self._command[f"{self._task}.reference_acceleration"]
        self._ff = self._command[f"{self._task}.feedforward"]
        self._home = float(self._x[self._world_axis])
        self._oscillator = PhaseOscillator(motion.frequency, motion.start_phase)
        self._wrenches = tick_format.reply.slice("wrenches")
        self._data = simulator.start(seed)
        self._fall_height = FALL_HEIGHT * float(robot.home_com[2])
        self._flight_height = FLIGHT_HEIGHT * float(robot.home_com[2])
        self._columns: dict[str, list[Any]] = {name: [] for name in _COLUMNS}
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
        for name in _SINGLE_PRECISION:
            log[name] = log[name].astype(np.float32)
        statuses = Counter(int(status) for status in log["status"])
        return Run(
            robot=self._simulator.robot.name,
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
        axis, data, state_map = self._component, self._data, self._simulator.state_map
        self._x[self._world_axis] = self._home + x
        self._xd[axis], self._xdd[axis], self._ff[axis] = xd, xdd, feedforward
        # positions and velocities first, so that the true centre of mass is the
        # one of the state that the controller is asked about
        mujoco.mj_step1(self._simulator.model, data)
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
        mujoco.mj_step2(self._simulator.model, data)


_COLUMNS = (
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
_SINGLE_PRECISION = ("all_errors", "q", "v", "tau", "wrenches")
