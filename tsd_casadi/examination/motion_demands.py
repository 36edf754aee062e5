"""What a motion asks of a robot: joints, torques, friction and soles over one lap."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pinocchio

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.hold import hold
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.references import References
from tsd_casadi.robot.reaching import reach
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_tasks import ComTaskFile, gain_matrix
from tsd_casadi.robot.support_polygon import margin, support_polygon
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.format import Status
from tsd_casadi.tick.tick import Tick

# postures of a lap: its extremes are among them for every sinusoid
PHASES = 8
# of masses and inertias, what the paper's experiments and most descriptions are off by
MODEL_ERROR = 0.1
GRAVITY = 9.81  # m/s^2


@dataclass(frozen=True)
class Demand:
    """The most that a lap asks of something, and of what.

    Attributes:
        value: Its size.
        of: The joint or contact.
    """

    value: float
    of: str


@dataclass(frozen=True)
class MotionDemands:
    """What a motion asks of a robot over a lap.

    Attributes:
        motion: The motion.
        failure: Why it cannot be done at all, None if it can.
        joint: Least distance of a joint to its limits, with the centre of mass higher or
            lower by what a wrong model causes [rad, m].
        torque: Largest |torque| / limit.
        friction: Largest tangential force / (friction times normal force).
        pressure: Least distance of the centre of pressure of the whole robot to the edge
            of what the feet span [m].
        extremes: Two postures half a lap apart, the first a quarter after the start.
    """

    motion: Motion
    failure: str | None = None
    joint: Demand | None = None
    torque: Demand | None = None
    friction: Demand | None = None
    pressure: float | None = None
    extremes: tuple[State, ...] = field(default=(), repr=False)


def demands_of(robot: Robot, controller: WholeBodyController, motion: Motion) -> MotionDemands:
    """Go through a lap, posture by posture, with the accelerations of its references.

    Velocities are left out: at a quarter of a hertz what they add to the torques is
    less than a hundredth of the weight's.
    """
    axes = motion.axes(robot)
    try:
        middle = motion.middle(robot)
    except InvalidValue as error:
        return MotionDemands(motion, failure=str(error))
    omega = 2 * math.pi * motion.frequency
    command = controller.command()
    hold(command, robot, middle)
    references = References(robot, controller.format, command, axes)
    joints, loads, postures = [], _Loads(robot), []
    for index in range(PHASES):
        offset = motion.offset(motion.start_phase + 2 * math.pi * index / PHASES)
        reached = []
        for sag in (0.0, -1.0, 1.0):
            moved = dict(zip(axes, map(float, offset.x), strict=True))
            for axis, length in _sag(robot).items():
                moved[axis] = moved.get(axis, 0.0) + sag * length
            reached.append(reach(robot, middle, moved))
        if reached[0] is None:
            return MotionDemands(motion, failure="is out of reach inside the joints' limits")
        # out of reach with the sag is on a limit with it
        joints += [_margin(robot, posture) for posture in reached if posture is not None]
        if None in reached:
            joints.append(Demand(0.0, _margin(robot, reached[0]).of))
        postures.append(reached[0])
        still = np.zeros(len(axes))
        references.write(offset.x, still, omega**2 * offset.by_phase_twice, still)
        command["posture.q_ref"] = reached[0].q[7:]
        tick = controller.tick(reached[0], command)
        if tick.status != Status.OK:
            return MotionDemands(motion, failure=f"has no torque ({tick.status.name.lower()})")
        loads.add(reached[0].q, tick)
    quarter = PHASES // 4
    return MotionDemands(
        motion,
        None,
        min(joints, key=lambda demand: demand.value),
        loads.torque,
        loads.friction,
        loads.pressure,
        (postures[quarter], postures[quarter + PHASES // 2]),
    )


def torque_at_rest(robot: Robot, controller: WholeBodyController) -> Demand:
    """Find the largest |torque| / limit at home, standing still."""
    command = controller.command()
    hold(command, robot, robot.home)
    loads = _Loads(robot)
    loads.add(robot.home.q, controller.tick(robot.home, command))
    return loads.torque


def _sag(robot: Robot) -> dict[str, float]:
    """By how much a wrong model moves the centre of mass up or down, E g / P, by axis [m]."""
    sags = {}
    for task in robot.description.tasks:
        if isinstance(task, ComTaskFile) and "z" in task.axes:
            z = task.axes.index("z")
            P = gain_matrix(task.P, len(task.axes))[z, z]
            if P > 0:
                sags[f"{task.name}.z"] = MODEL_ERROR * GRAVITY / float(P)
    return sags


def _margin(robot: Robot, posture: State) -> Demand:
    """Find the joint that is nearest to its limits."""
    model, q = robot.model, posture.q[7:]
    margins = np.minimum(q - model.lowerPositionLimit[7:], model.upperPositionLimit[7:] - q)
    index = int(np.argmin(margins))
    return Demand(float(margins[index]), robot.joint_names[index])


class _Loads:
    """The worst of some ticks."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.torque = Demand(0.0, "")
        self.friction = Demand(0.0, "")
        self.pressure = math.inf

    def add(self, q: Vector, tick: Tick) -> None:
        robot = self._robot
        shares = np.abs(tick.tau) / np.minimum(robot.torque_limit, robot.stall_torque)
        index = int(np.argmax(shares))
        if shares[index] > self.torque.value:
            self.torque = Demand(float(shares[index]), self._robot.joint_names[index])
        for contact in self._robot.description.contacts:
            wrench = tick.wrenches[contact.name]
            # forces of the pyramid: each tangential axis by itself
            share = float(np.abs(wrench[:2]).max() / (contact.friction * max(wrench[2], 1e-9)))
            if share > self.friction.value:
                self.friction = Demand(share, contact.name)
        left = margin(support_polygon(self._robot, q), self._center_of_pressure(q, tick.qdd))
        self.pressure = min(self.pressure, left)

    def _center_of_pressure(self, q: Vector, qdd: Vector) -> Vector:
        """Where the ground carries the robot, (2,) [m]: what the base's rows leave to it."""
        model = self._robot.model
        base = pinocchio.SE3(pinocchio.Quaternion(q[3:7]).matrix(), q[:3])
        rows = pinocchio.rnea(model, model.createData(), q, np.zeros(model.nv), qdd)[:6]
        wrench = base.act(pinocchio.Force(rows[:3], rows[3:]))
        return np.asarray([-wrench.angular[1], wrench.angular[0]] / wrench.linear[2])
