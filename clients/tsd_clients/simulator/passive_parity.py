"""Whether a scene has forces that no description of rigid bodies has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.exceptions.discrepancy import Discrepancy
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.rounding import TOLERANCE

# by MuJoCo's array, of which not every release has all: what it is called in a scene
JOINTS = {"jnt_stiffness": "stiffness", "jnt_stiffnesspoly": "stiffness"}
DEGREES_OF_FREEDOM = {
    "dof_damping": "damping",
    "dof_dampingpoly": "damping",
    "dof_frictionloss": "friction loss",
}
ACTUATORS = {
    "actuator_damping": "damping",
    "actuator_dampingpoly": "damping",
    "actuator_armature": "armature",
}
TENDONS = {
    "tendon_stiffness": "stiffness",
    "tendon_damping": "damping",
    "tendon_frictionloss": "friction loss",
    "tendon_armature": "armature",
}
BODIES = {"body_gravcomp": "gravity compensation"}
MEDIUM = {"density": "kg/m^3", "viscosity": "Pa s"}
FLAGS = {
    mujoco.mjtDisableBit.mjDSBL_CONTACT: "contact",
    mujoco.mjtDisableBit.mjDSBL_CONSTRAINT: "constraint",
    mujoco.mjtDisableBit.mjDSBL_LIMIT: "limit",
    mujoco.mjtDisableBit.mjDSBL_ACTUATION: "actuation",
    mujoco.mjtDisableBit.mjDSBL_GRAVITY: "gravity",
}
ADVICE = (
    "set it to 0; what the real robot has belongs in the robot file's section hardware "
    "and is simulated with --hardware"
)


def compare_passive_forces(robot: Robot, model: Any) -> list[Discrepancy]:
    """Look for springs, damping, friction, fluids, equalities and another gravity.

    Args:
        model: ``mujoco.MjModel``.
    """

    def joint(index: int) -> str:
        return f"joint {_named(model.joint(index), index)}"

    found = [
        *_nonzero(model, JOINTS, joint),
        *_nonzero(model, DEGREES_OF_FREEDOM, lambda index: joint(model.dof_jntid[index])),
        *_nonzero(model, ACTUATORS, lambda i: f"actuator {_named(model.actuator(i), i)}"),
        *_nonzero(model, TENDONS, lambda i: f"tendon {_named(model.tendon(i), i)}"),
        *_nonzero(model, BODIES, lambda i: f"body {_named(model.body(i), i)}"),
    ]
    for index in np.flatnonzero(model.eq_active0):
        name = _named(model.equality(int(index)), int(index))
        remedy = "delete it; what it fixes may be locked in the robot file"
        found.append(Discrepancy(f"equality {name}", "state", "active", "none", remedy))
    for name, unit in MEDIUM.items():
        value = float(getattr(model.opt, name))
        if value:
            found.append(Discrepancy("medium", name, f"{value:g} {unit}", f"0 {unit}", ADVICE))
    off = [name for flag, name in FLAGS.items() if model.opt.disableflags & flag]
    found += [
        Discrepancy("option", f"flag {name}", "disable", "enable", "delete it") for name in off
    ]
    given, gravity = model.opt.gravity, robot.model.gravity.linear
    if np.linalg.norm(given - gravity) > TOLERANCE * np.linalg.norm(gravity):
        values = f"({_numbers(given)}) m/s^2", f"({_numbers(gravity)}) m/s^2"
        remedy = f'set gravity="{_numbers(gravity)}"'
        found.append(Discrepancy("option", "gravity", *values, remedy))
    return found


def _nonzero(
    model: Any, arrays: dict[str, str], element: Callable[[int], str]
) -> list[Discrepancy]:
    found = {}
    for array, quantity in arrays.items():
        values = getattr(model, array, None)
        if values is None or not len(values):
            continue
        for index, row in enumerate(values.reshape(len(values), -1)):
            if row.any():
                worst = float(row[np.argmax(np.abs(row))])
                # a free joint's six count once
                key = (element(index), quantity)
                found[key] = Discrepancy(*key, f"{worst:.6g}", "0", ADVICE)
    return list(found.values())


def _named(described: Any, index: int) -> str:
    return str(described.name) or f"number {index}"


def _numbers(vector: Any) -> str:
    return " ".join(f"{x:.6g}" for x in vector)
