r"""The simulated robot stands in many poses while the ground tells its centre of pressure.

.. math:: p_{cop,x} = -M_y / F_z, \qquad p_{cop,y} = M_x / F_z

with force F and moment M of the ground about the world's origin.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pinocchio

from tsd_casadi.center_of_mass.fit import StaticPose
from tsd_casadi.center_of_mass.pose_design import design_poses
from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import SimulationError
from tsd_casadi.motions.posture_move import Way, duration_of, short_way
from tsd_casadi.repetition.repetition import FALL_HEIGHT, Progress
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.format import Status
from tsd_clients.simulator.mujoco_plant import MujocoPlant
from tsd_clients.simulator.simulator import MujocoSimulator

SETTLE, AVERAGE = 0.6, 0.2  # s, after each move
# beyond these a foot is not flat on the ground [m, rad]
FLATNESS, TILTED = 1e-3, 5e-3
# of the centre of pressure from one half of the averaging to the other: more is
# not at rest [m]
DRIFT = 1e-3
ADVICE = "Try a smaller model error"


def collect(
    simulator: MujocoSimulator,
    controller: WholeBodyController,
    *,
    count: int = 30,
    inclinometer: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> list[StaticPose]:
    """Let the robot stand in some poses and measure each, with perfect force sensors.

    What the hardware effects do to joint angles and base is in the
    measurements; ``with_noise`` adds that of the centre of pressure. Among them
    is the ground giving way under the more loaded foot: the robot leans a little
    further than its joint angles tell, so that all heights come out larger. An
    inclinometer on the base tells the lean.

    Args:
        inclinometer: Standard deviation of the base's measured inclination
            [rad]; None leaves it to the joint angles or, without the hardware
            effect 'flat_feet', to the truth.
        progress: Called with (done, total) poses.

    Returns:
        One measurement per pose, the most telling first: the first n of them
        are a good collection of n. Poses are left out where the centre of
        pressure did not come to rest or, as the joint angles have it, a foot
        was not on the ground.

    Raises:
        InvalidValue: If the count is out of range for the robot.
        SimulationError: If the robot fell or a tick failed.
    """
    robot = simulator.robot
    postures = design_poses(robot, count, seed=seed)
    plant = simulator.body(simulator.near(robot.home, seed), robot.home, seed)
    standing = _Standing(simulator, plant, controller, inclinometer, seed)
    measured: dict[int, StaticPose | None] = {}
    for index in short_way(robot, postures):
        standing.move(postures[index])
        measured[index] = standing.measure()
        if progress is not None:
            progress(len(measured), count)
    in_order = (measured[index] for index in range(count))
    return [pose for pose in in_order if pose is not None]


def with_noise(
    poses: Sequence[StaticPose], standard_deviation: float, *, seed: int = 0
) -> list[StaticPose]:
    """Add noise to the poses' centres of pressure.

    Args:
        poses: From ``collect``.
        standard_deviation: Along each axis [m].
    """
    noise = standard_deviation * np.random.default_rng((seed, 3)).standard_normal((len(poses), 2))
    return [
        replace(pose, center_of_pressure=pose.center_of_pressure + n)
        for pose, n in zip(poses, noise, strict=True)
    ]


def true_center_of_mass(simulator: MujocoSimulator, q: Vector) -> Vector:
    """Compute the simulated robot's centre of mass, (3,) [m], world frame.

    Args:
        q: Configuration, (nq,).
    """
    data = mujoco.MjData(simulator.model)
    simulator.state_map.write(data, State(q, np.zeros(simulator.robot.nv)))
    mujoco.mj_kinematics(simulator.model, data)
    mujoco.mj_comPos(simulator.model, data)
    return np.array(data.subtree_com[simulator.state_map.base_body])


class _Standing:
    """The robot under way from pose to pose."""

    def __init__(
        self,
        simulator: MujocoSimulator,
        plant: MujocoPlant,
        controller: WholeBodyController,
        inclinometer: float | None,
        seed: int,
    ) -> None:
        self._robot, self._plant, self._controller = simulator.robot, plant, controller
        self._period = simulator.period
        self._inclinometer, self._rng = inclinometer, np.random.default_rng((seed, 5))
        self._command = controller.command()
        self._command["period"] = self._period
        self._last = simulator.robot.home
        self._ticks = 0

    def move(self, target: State) -> None:
        """Go to a posture and let the robot settle."""
        duration = duration_of(self._robot, self._last, target)
        way = Way(self._robot, self._command, self._last, target, duration)
        count = math.ceil(duration / self._period)
        for tick in range(1, count + 1):
            way.write(tick / count)
            self._step()
        for _ in range(round(SETTLE / self._period)):
            self._step()
        self._last = target

    def measure(self) -> StaticPose | None:
        """Average over a while; None if the robot does not stand still and flat."""
        configurations, truths, centers, forces = [], [], [], []
        for _ in range(round(AVERAGE / self._period)):
            true, measured = self._step()
            force, center = self._plant.ground_force()
            configurations.append(measured.q)
            truths.append(true.q[3:7])
            centers.append(_as_believed(center, true, measured))
            forces.append(force[2])
        q = np.mean(configurations, axis=0)
        q[3:7] = _unit(q[3:7])
        if self._inclinometer is not None:
            # upwards as an accelerometer at rest tells it, in the base's axes
            upwards = pinocchio.Quaternion(_unit(np.mean(truths, axis=0))).matrix()[2]
            upwards = _unit(upwards + self._inclinometer * self._rng.standard_normal(3))
            q[:7] = _inclined(self._robot, q, upwards)
        earlier, later = (np.mean(half, axis=0) for half in np.array_split(centers, 2))
        if not (_stands_flat(self._robot, q) and np.abs(later - earlier).max() < DRIFT):
            return None
        return StaticPose(q, np.mean(centers, axis=0), float(np.mean(forces)))

    def _step(self) -> tuple[State, State]:
        true, measured = self._plant.measure()
        time = self._ticks * self._period
        if not self._plant.com[2] > FALL_HEIGHT * self._robot.home_com[2]:
            raise SimulationError(f"the robot fell from a static pose after {time:.2f} s. {ADVICE}")
        tick = self._controller.tick(measured, self._command)
        if tick.status is not Status.OK:
            raise SimulationError(
                f"the controller answered a tick of the static poses after {time:.2f} s with a "
                f"safe torque ({tick.status.name.lower()}). {ADVICE}"
            )
        self._plant.step(tick.tau, time)
        self._ticks += 1
        return true, measured


def _as_believed(center: Vector, true: State, measured: State) -> Vector:
    """Put a point of the ground where the robot believes it to be.

    Its force sensors tell it relative to its own body.
    """
    body, believed = (pinocchio.XYZQUATToSE3(state.q[:7]) for state in (true, measured))
    return np.array(believed.act(body.actInv(np.append(center, 0.0)))[:2])


def _inclined(robot: Robot, q: Vector, upwards: Vector) -> Vector:
    """Lean the base's pose about the middle of the feet until upwards is up, (7,)."""
    base = pinocchio.XYZQUATToSE3(q[:7])
    found = pinocchio.Quaternion.FromTwoVectors(base.rotation @ upwards, np.array([0.0, 0.0, 1.0]))
    middle = np.mean([sole.translation for sole in robot.sole_placements(q)], axis=0)
    place = middle + found.matrix() @ (base.translation - middle)
    return np.asarray(pinocchio.SE3ToXYZQUAT(pinocchio.SE3(found.matrix() @ base.rotation, place)))


def _stands_flat(robot: Robot, q: Vector) -> bool:
    """Tell whether the feet lie in one plane, whatever the base's inclination."""
    places = robot.sole_placements(q)
    normal = _ground_normal(robot, places)
    heights = [normal @ place.translation for place in places]
    tilts = [foot.tilt(place, normal) for foot, place in zip(robot.feet, places, strict=True)]
    return bool(np.ptp(heights) < FLATNESS and max(tilts) < TILTED)


def _ground_normal(robot: Robot, places: list[Any]) -> Vector:
    """Compute the mean normal of the soles, or without any of the plane through the points."""
    feet = zip(robot.feet, places, strict=True)
    normals = np.vstack([foot.normals(place) for foot, place in feet])
    if len(normals) > 0:
        return _unit(np.sum(normals, axis=0))
    points = np.array([place.translation for place in places])
    normal = np.linalg.svd(points - points.mean(axis=0))[2][-1]
    return np.asarray(normal * np.copysign(1.0, normal[2]))


def _unit(vector: Vector) -> Vector:
    return np.asarray(vector / np.linalg.norm(vector))
