"""Whether a scene's joints and motors are the description's, and nothing but those."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pinocchio

from tsd_casadi.exceptions.discrepancy import Discrepancy
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.rounding import TOLERANCE
from tsd_clients.simulator.state_map import StateMap


def compare_joints(robot: Robot, model: Any, state_map: StateMap) -> list[Discrepancy]:
    """Compare reflected inertias, ranges and what the motors can do, joint by joint.

    Args:
        model: ``mujoco.MjModel``.
    """
    M = pinocchio.crba(robot.model, robot.model.createData(), robot.home.q)
    found = []
    for index, name in enumerate(robot.joint_names):
        joint = int(model.dof_jntid[state_map.v_joints[index]])
        place = robot.model.joints[robot.model.getJointId(name)]
        found += _armature(
            f"joint {name}",
            float(model.dof_armature[state_map.v_joints[index]]),
            float(robot.model.armature[place.idx_v]),
            float(M[place.idx_v, place.idx_v]),
        )
        low = float(robot.model.lowerPositionLimit[place.idx_q])
        high = float(robot.model.upperPositionLimit[place.idx_q])
        found += _range(f"joint {name}", model, joint, (low, high))
        found += _motor(name, model, int(state_map.actuators[index]), joint, robot, index)
    return found


def _armature(joint: str, found: float, expected: float, inertia: float) -> list[Discrepancy]:
    # as much as it adds to what the motor has to turn anyway
    if abs(found - expected) <= TOLERANCE * inertia:
        return []
    remedy = f'set armature="{expected:.9g}"' if expected else "delete it"
    remedy += (
        "; a rotor that the controller does not know of is simulated with the robot "
        "file's section hardware and --hardware armature"
    )
    values = f"{found:.6g} kg m^2", f"{expected:.6g} kg m^2"
    return [Discrepancy(joint, "armature", *values, remedy)]


def _range(joint: str, model: Any, index: int, expected: tuple[float, ...]) -> list[Discrepancy]:
    found: tuple[float, ...] = (-np.inf, np.inf)
    if model.jnt_limited[index]:
        found = tuple(map(float, model.jnt_range[index]))
    if not np.isfinite(expected).all():
        expected = (-np.inf, np.inf)
    same = (
        one == other or abs(one - other) <= TOLERANCE * max(1.0, abs(other))
        for one, other in zip(found, expected, strict=True)
    )
    if all(same):
        return []
    unlimited = not np.isfinite(expected).all()
    remedy = 'set limited="false"' if unlimited else f'set range="{_pair(expected)}"'
    remedy += ", or override position in the robot file"
    unit = "m" if model.jnt_type[index] == mujoco.mjtJoint.mjJNT_SLIDE else "rad"
    values = f"[{_pair(found)}] {unit}", f"[{_pair(expected)}] {unit}"
    return [Discrepancy(joint, "range", *values, remedy)]


def _motor(
    name: str, model: Any, actuator: int, joint: int, robot: Robot, index: int
) -> list[Discrepancy]:
    limit = float(robot.torque_limit[index])
    unit = "N" if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE else "N m"
    ranges = {
        "control range": (model.actuator_ctrllimited, model.actuator_ctrlrange, actuator),
        "force range": (model.actuator_forcelimited, model.actuator_forcerange, actuator),
        "actuator force range": (model.jnt_actfrclimited, model.jnt_actfrcrange, joint),
    }
    found = []
    for quantity, (limited, bounds, place) in ranges.items():
        low, high = map(float, bounds[place])
        enough = limit * (1 - TOLERANCE)
        if limited[place] and not low <= -enough < enough <= high:
            element = f"joint {name}" if place is joint else f"motor of joint {name}"
            remedy = (
                f'set it to "{-limit:g} {limit:g}", or override effort in the robot file '
                "with what the motor can do"
            )
            values = f"[{_pair((low, high))}] {unit}", f"[{_pair((-limit, limit))}] {unit}"
            found.append(Discrepancy(element, quantity, *values, remedy))
    return found


def _pair(bounds: tuple[float, ...]) -> str:
    return " ".join(f"{x:.6g}" for x in bounds)
