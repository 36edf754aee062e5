"""Whether a robot's description and its MuJoCo scene are the same robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import pinocchio

from tsd_casadi.exceptions import ParityError
from tsd_casadi.exceptions.discrepancy import Discrepancy
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State
from tsd_clients.simulator.body_parity import compare_bodies
from tsd_clients.simulator.ground_parity import compare_ground
from tsd_clients.simulator.joint_parity import compare_joints
from tsd_clients.simulator.passive_parity import compare_passive_forces
from tsd_clients.simulator.rounding import TOLERANCE
from tsd_clients.simulator.scene import scene_file
from tsd_clients.simulator.scene_bodies import SceneBodies
from tsd_clients.simulator.state_map import StateMap

# of the whole robot, relative: what parts that are each within their tolerance can
# add up to
WHOLE = 10 * TOLERANCE


@dataclass(frozen=True)
class Parity:
    """Largest absolute differences over some random states.

    Attributes:
        mass_matrix: [kg, kg m, kg m^2].
        bias_forces: [N, N m].
        center_of_mass: [m].
    """

    mass_matrix: float
    bias_forces: float
    center_of_mass: float


def random_state(robot: Robot, rng: np.random.Generator) -> State:
    """Draw a state with every coordinate different from zero.

    Returns:
        Joint angles within their limits, base anywhere and turned, all
        velocities nonzero.
    """
    quaternion = rng.normal(size=4)
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    q = np.concatenate(
        (rng.normal(size=3), quaternion / np.linalg.norm(quaternion), rng.uniform(low, high))
    )
    return State(q=q, v=rng.normal(size=robot.nv))


def measure_parity(robot: Robot, model: Any, states: int = 5, seed: int = 0) -> Parity:
    """Compare the two descriptions at random states.

    With v_pin = T v_mj, M_mj = T^T M T and h_mj = T^T (M dT/dt v_mj + h).

    Args:
        model: ``mujoco.MjModel`` of its scene.

    Returns:
        The largest differences.
    """
    rng = np.random.default_rng(seed)
    state_map = StateMap(robot, model)
    data, pin_data = mujoco.MjData(model), robot.model.createData()
    worst = np.zeros(3)
    for _ in range(states):
        state = random_state(robot, rng)
        state_map.write(data, state)
        mujoco.mj_forward(model, data)
        T = state_map.velocity_transform(state)
        M = pinocchio.crba(robot.model, pin_data, state.q)
        M = np.triu(M) + np.triu(M, 1).T
        h = pinocchio.nonLinearEffects(robot.model, pin_data, state.q, state.v)
        M_mj = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M_mj)
        h_mj = T.T @ (M @ state_map.transform_drift(state) + h)
        com = pinocchio.centerOfMass(robot.model, pin_data, state.q)
        differences = (
            np.abs(M_mj - T.T @ M @ T).max(),
            np.abs(data.qfrc_bias - h_mj).max(),
            np.abs(data.subtree_com[state_map.base_body] - com).max(),
        )
        worst = np.maximum(worst, differences)
    return Parity(*map(float, worst))


def check_parity(robot: Robot, model: Any) -> None:
    """Refuse a scene that is not the robot described.

    Args:
        model: ``mujoco.MjModel`` of its scene.

    Raises:
        ParityError: With everything that differs by more than rounded text does.
    """
    found = find_discrepancies(robot, model)
    if found:
        raise ParityError(robot.name, scene_file(robot), found)


def find_discrepancies(robot: Robot, model: Any) -> list[Discrepancy]:
    """Compare bodies, joints, motors, passive forces, floor and feet, then all together.

    Args:
        model: ``mujoco.MjModel`` of its scene.

    Returns:
        What differs, by name of body, joint or contact.
    """
    state_map = StateMap(robot, model)
    scene = SceneBodies(robot, model, state_map)
    bodies = compare_bodies(robot, scene)
    found = [
        *bodies.discrepancies,
        *compare_joints(robot, model, state_map),
        *compare_passive_forces(robot, model),
        *compare_ground(robot, model, scene, bodies.displacements),
    ]
    return found or _compare_dynamics(robot, model)


def _compare_dynamics(robot: Robot, model: Any) -> list[Discrepancy]:
    """Look for what no comparison of parts has seen."""
    parity = measure_parity(robot, model)
    height, weight = float(robot.home_com[2]), robot.weight
    mass = weight / float(np.linalg.norm(robot.model.gravity.linear))
    scales = (max(mass, mass * height**2), weight * max(1.0, height), height)
    return [
        Discrepancy(
            "whole robot",
            quantity.replace("_", " "),
            f"{difference / scale:.1e} of its size off",
            f"{WHOLE:.0e} at most",
            "compare joint axes, placements and references of the two files",
        )
        for (quantity, difference), scale in zip(vars(parity).items(), scales, strict=True)
        if difference > WHOLE * scale
    ]
