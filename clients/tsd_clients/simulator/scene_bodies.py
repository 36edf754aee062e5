"""A scene's bodies gathered by the joint that moves them, as a description has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import pinocchio

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, State, Vector
from tsd_clients.simulator.state_map import StateMap

HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


@dataclass(frozen=True)
class SceneBody:
    """A joint of the scene and all that it moves rigidly, all joints at zero.

    Attributes:
        name: Of the body in the scene.
        parent: Name of the joint before it; empty for the floating base.
        kind: ``mjJNT_HINGE`` or ``mjJNT_SLIDE``, as int; -1 for the floating base.
        frame: ``pinocchio.SE3`` of the scene's body frame in the world.
        anchor: A point of the joint's axis, (3,) [m], world frame.
        axis: Unit vector, (3,), world frame.
        inertia: ``pinocchio.Inertia`` in the world frame.
    """

    name: str
    parent: str
    kind: int
    frame: Any
    anchor: Vector
    axis: Vector
    inertia: Any


class SceneBodies:
    """A scene with all joints at zero and the base at the origin.

    Attributes:
        joint_of: Name of the joint that moves each of MuJoCo's bodies; empty for
            the floating base, None for what does not move.
        bodies: By the name of their joint, the floating base's is empty.
        data: ``mujoco.MjData`` with the kinematics of that posture.
    """

    def __init__(self, robot: Robot, model: Any, state_map: StateMap) -> None:
        """Gather what each joint moves.

        Args:
            model: ``mujoco.MjModel``.
        """
        self.data = mujoco.MjData(model)
        neutral = State(pinocchio.neutral(robot.model), np.zeros(robot.nv))
        state_map.write(self.data, neutral)
        mujoco.mj_kinematics(model, self.data)
        self.joint_of: list[str | None] = [None]
        for body in range(1, model.nbody):
            joints = _joints(model, body)
            inherited = self.joint_of[model.body_parentid[body]]
            self.joint_of.append(_name(model, joints[-1]) if joints else inherited)
        self.bodies = {
            _name(model, joint): self._gather(model, joint) for joint in range(model.njnt)
        }

    def _gather(self, model: Any, joint: int) -> SceneBody:
        data, body, name = self.data, int(model.jnt_bodyid[joint]), _name(model, joint)
        inertia = pinocchio.Inertia.Zero()
        for index, mover in enumerate(self.joint_of):
            if mover == name:
                inertia += _inertia(model, data, index)
        before = [each for each in _joints(model, body) if each < joint]
        parent = self.joint_of[model.body_parentid[body]]
        return SceneBody(
            name=model.body(body).name or f"number {body}",
            parent=_name(model, before[-1]) if before else parent or "",
            kind=-1 if name == "" else int(model.jnt_type[joint]),
            frame=pinocchio.SE3(data.xmat[body].reshape(3, 3), data.xpos[body]),
            anchor=data.xanchor[joint].copy(),
            axis=data.xaxis[joint].copy(),
            inertia=inertia,
        )


def _joints(model: Any, body: int) -> list[int]:
    first = int(model.body_jntadr[body])
    return list(range(first, first + int(model.body_jntnum[body])))


def _name(model: Any, joint: int) -> str:
    """Name a joint; the free joint's name is the scene's business."""
    free = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE
    return "" if free else str(model.joint(joint).name)


def _inertia(model: Any, data: Any, body: int) -> Any:
    axes: Matrix = data.ximat[body].reshape(3, 3)
    rotational = axes @ np.diag(model.body_inertia[body]) @ axes.T
    return pinocchio.Inertia(float(model.body_mass[body]), data.xipos[body], rotational)
