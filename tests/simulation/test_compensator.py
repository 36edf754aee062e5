from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tsd_casadi import Command, Controller, Robot, Run, Squat, State, Tick
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.repetition import HOLD
from tsd_casadi.state import Vector
from tsd_clients import MujocoSimulator
from tsd_clients.simulator.disturbances import Disturbance
from tsd_clients.simulator.state_map import StateMap

SQUAT = Squat(amplitude=0.01, frequency=1.0)
TIMESTEP = 1e-3  # s


class Limp:
    """A controller that answers nothing but a mark in the first torque; the robot falls."""

    def __init__(self, controller: Controller) -> None:
        self.format = controller.format
        self._controller = controller
        self.commands: list[Vector] = []

    def command(self) -> Command:
        return self._controller.command()

    def tick(self, state: State, command: Command) -> Tick:
        reply = np.zeros(self.format.reply.size)
        reply[self.format.reply.slice("tau")] = 0.125
        self.commands.append(command.request.copy())
        return Tick(self.format, reply)

    def seen(self, field: str) -> Vector:
        """A field of the command, tick by tick."""
        return np.array(self.commands)[:, self.format.request.slice(field)]


class Applied(Disturbance):
    """Remembers what the motors were told."""

    def __init__(self) -> None:
        self.torques: list[Vector] = []

    def apply(self, data: Any, state_map: StateMap, time: float) -> None:
        self.torques.append(data.ctrl[state_map.actuators].copy())


class Diary(Compensator):
    """Notes every call."""

    def __init__(self, name: str, calls: list[tuple[str, str, float]]) -> None:
        self.name, self.calls = name, calls
        self.settings: list[Setting] = []

    def start(self, setting: Setting) -> None:
        self.settings.append(setting)
        self.calls.append((self.name, "start", -1.0))

    def before(self, moment: Moment) -> None:
        assert moment.tick is None
        assert moment.tau.size == 0
        self.calls.append((self.name, "before", moment.time))

    def after(self, moment: Moment) -> None:
        assert moment.tick is not None
        self.calls.append((self.name, "after", moment.time))


class Change(Compensator):
    """Adds to whatever may be changed."""

    def __init__(
        self,
        feedforward: float = 0.0,
        shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
        shift_rate: tuple[float, float, float] = (0.0, 0.0, 0.0),
        tau: float = 0.0,
    ) -> None:
        self.feedforward, self.shift, self.shift_rate, self.tau = (
            feedforward,
            shift,
            shift_rate,
            tau,
        )

    def before(self, moment: Moment) -> None:
        moment.feedforward += self.feedforward
        moment.shift += self.shift
        moment.shift_rate += self.shift_rate

    def after(self, moment: Moment) -> None:
        moment.tau += self.tau


@pytest.fixture(scope="module")
def simulator(robot: Robot) -> MujocoSimulator:
    return MujocoSimulator(robot)


@pytest.fixture
def limp(controller: Controller) -> Limp:
    return Limp(controller)


def test_the_base_class_changes_nothing(simulator: MujocoSimulator, limp: Limp) -> None:
    without = simulator.run(limp, SQUAT)
    run = simulator.run(limp, SQUAT, compensators=[Compensator(), Compensator()])
    for name in ("q", "tau", "reference", "feedforward", "error"):
        np.testing.assert_array_equal(run.log[name], without.log[name])


def test_each_is_asked_once_a_tick_in_the_order_of_the_list(
    simulator: MujocoSimulator, limp: Limp
) -> None:
    calls: list[tuple[str, str, float]] = []
    run = simulator.run(limp, SQUAT, compensators=[Diary("one", calls), Diary("other", calls)])
    assert run.fell
    assert run.ticks > 100
    expected = [("one", "start", -1.0), ("other", "start", -1.0)]
    for tick in range(run.ticks):
        for what in ("before", "after"):
            expected += [(name, what, TIMESTEP * tick) for name in ("one", "other")]
    assert calls == expected


def test_each_run_is_a_new_start(simulator: MujocoSimulator, limp: Limp, robot: Robot) -> None:
    diary = Diary("one", [])
    for _ in range(2):
        simulator.run(limp, SQUAT, compensators=[diary])
    assert len(diary.settings) == 2
    setting = diary.settings[0]
    assert setting.robot is robot
    assert setting.controller is limp
    assert (setting.motion, setting.period) == (SQUAT, TIMESTEP)
    assert (setting.axes, setting.learned) == (("com.z", "com.x", "com.y"), 3)
    names = [".".join(limp.format.axes[index]) for index in setting.index]
    assert names == list(setting.axes)


def test_a_moment_tells_what_the_tick_is_about(
    simulator: MujocoSimulator, controller: Controller
) -> None:
    class Remember(Compensator):
        def __init__(self) -> None:
            self.moments: list[tuple[float, float, int]] = []
            self.vectors: list[tuple[Vector, Vector]] = []
            self.wrong: list[float] = []

        def after(self, moment: Moment) -> None:
            self.moments.append((moment.time, moment.phase, moment.lap))
            self.vectors.append((moment.reference.x, moment.feedforward))
            assert moment.tick is not None
            self.wrong.append(float(np.abs(moment.tick.tau - moment.tau).max()))

    remember = Remember()
    run = simulator.run(controller, SQUAT, laps=2, compensators=[remember])
    time, phase, lap = np.array(remember.moments).T
    x, feedforward = (np.array(values) for values in zip(*remember.vectors, strict=True))
    np.testing.assert_array_equal(time, run.log["time"])
    np.testing.assert_array_equal(phase, run.log["phase"])
    np.testing.assert_array_equal(lap, run.log["lap"])
    np.testing.assert_array_equal(x, run.log["reference"])
    assert x.shape == feedforward.shape == (run.ticks, 3)
    assert not feedforward.any()
    assert max(remember.wrong) == 0.0


def test_a_shift_moves_the_reference_that_the_controller_sees(
    simulator: MujocoSimulator, limp: Limp, robot: Robot
) -> None:
    simulator.run(limp, SQUAT)
    position, velocity = limp.seen("com.reference"), limp.seen("com.reference_velocity")
    np.testing.assert_allclose(position[0], robot.home_com, atol=1e-12)
    limp.commands.clear()
    changes = [
        Change(shift=(0.01, -0.02, 0.03), shift_rate=(0.1, 0.2, 0.3)),
        Change(shift=(0.0, 0.0, 0.005)),
    ]
    run = simulator.run(limp, SQUAT, compensators=changes)
    moved = limp.seen("com.reference") - position
    np.testing.assert_allclose(moved, np.tile([0.01, -0.02, 0.035], (run.ticks, 1)), atol=1e-12)
    faster = limp.seen("com.reference_velocity") - velocity
    np.testing.assert_allclose(faster, np.tile([0.1, 0.2, 0.3], (run.ticks, 1)), atol=1e-12)
    # what was wanted of the motion stays what it was
    assert not run.log["reference"].any()


def test_the_robot_follows_a_shift(simulator: MujocoSimulator, controller: Controller) -> None:
    run = simulator.run(controller, SQUAT, laps=2, compensators=[Change(shift=(0.0, 0.0, -0.01))])
    assert run.steady
    # the controller is content, the robot 1 cm too low
    assert all(error.rms < 2e-4 for error in run.errors.values())
    true, seen = (run.along(name, "com.z") for name in ("true_error", "error"))
    np.testing.assert_allclose(true[run.log["measured"]], 0.01, atol=5e-4)
    np.testing.assert_allclose(true - seen, 0.01, atol=1e-9, err_msg="exact model")


def test_feedforward_adds_up_and_is_logged(simulator: MujocoSimulator, limp: Limp) -> None:
    changes = [Change(feedforward=0.25), Change(feedforward=-0.75)]
    run = simulator.run(limp, SQUAT, axes=("com.z",), compensators=changes)
    np.testing.assert_array_equal(run.log["feedforward"], -0.5)
    seen = limp.seen("com.feedforward")
    np.testing.assert_array_equal(seen[:, 2], -0.5)
    assert not seen[:, :2].any()
    limp.commands.clear()
    run = simulator.run(limp, SQUAT, axes=("com.y", "torso.rz"), compensators=changes)
    assert run.axes == ("com.y", "torso.rz", "com.z")
    np.testing.assert_array_equal(run.log["feedforward"], -0.5)
    seen = np.hstack([limp.seen(f"{task}.feedforward") for task in ("com", "torso", "pelvis")])
    np.testing.assert_array_equal(seen[0], [0.0, -0.5, -0.5, 0.0, 0.0, -0.5, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(seen, np.tile(seen[0], (run.ticks, 1)))


def applied_and_logged(
    simulator: MujocoSimulator, limp: Limp, *compensators: Compensator
) -> tuple[Run, Vector]:
    applied = Applied()
    run = simulator.run(limp, SQUAT, compensators=compensators, disturbances=[applied])
    return run, np.array(applied.torques)


def test_torque_is_applied_and_logged_as_corrected(simulator: MujocoSimulator, limp: Limp) -> None:
    run, applied = applied_and_logged(simulator, limp, Change(tau=0.5), Change(tau=0.25))
    np.testing.assert_array_equal(applied, 0.875)
    np.testing.assert_array_equal(run.log["tau"], 0.875)


def test_torque_is_cut_off_at_the_limits(
    simulator: MujocoSimulator, limp: Limp, robot: Robot
) -> None:
    run, applied = applied_and_logged(simulator, limp, Change(tau=-1e6))
    np.testing.assert_array_equal(applied, np.tile(-robot.torque_limit, (run.ticks, 1)))
    np.testing.assert_array_equal(run.log["tau"], applied)


def test_the_answer_stays_what_the_controller_said(simulator: MujocoSimulator, limp: Limp) -> None:
    class Check(Compensator):
        def after(self, moment: Moment) -> None:
            assert moment.tick is not None
            np.testing.assert_array_equal(moment.tick.tau, 0.125)
            np.testing.assert_array_equal(moment.tau, 2.125)

    run = simulator.run(limp, SQUAT, compensators=[Change(tau=2.0), Check()])
    assert run.ticks > 0


def test_corrections_see_the_measured_state(robot: Robot, limp: Limp) -> None:
    class Angles(Compensator):
        def __init__(self) -> None:
            self.q: list[Vector] = []

        def before(self, moment: Moment) -> None:
            self.q.append(moment.state.q)

    angles = Angles()
    run = MujocoSimulator(robot, hardware=["quantisation"]).run(limp, SQUAT, compensators=[angles])
    hardware = robot.description.hardware
    assert hardware is not None
    steps = np.array(angles.q)[:, 7:] / hardware.encoder_resolution
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    # the records keep the truth
    assert 1e-6 < np.abs(run.log["q"][:, 7:] - np.array(angles.q)[:, 7:]).max() < 2e-5
    assert run.ticks < round(HOLD / TIMESTEP)
