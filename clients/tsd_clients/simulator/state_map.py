"""MuJoCo's conventions and Pinocchio's: the one place where they meet.

MuJoCo keeps quaternions as wxyz and the base's linear velocity in world axes;
Pinocchio wants xyzw and the base frame. Both keep the angular velocity in the
base frame. Joints are matched by name.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, State, Vector
from tsd_clients.simulator.scene import scene_file

WXYZ_TO_XYZW = [1, 2, 3, 0]
XYZW_TO_WXYZ = [3, 0, 1, 2]
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])  # of a quaternion wxyz


class StateMap:
    """Converts between the state of a scene and that of a robot.

    Attributes:
        actuators: Actuator of each joint, (n,), in the robot's joint order.
        v_joints: Index of each joint in MuJoCo's velocity, (n,).
        base_body: Index of the floating base's body.
    """

    def __init__(self, robot: Robot, model: Any) -> None:
        """Find the robot's joints and motors in a scene.

        Args:
            model: ``mujoco.MjModel`` of the scene.

        Raises:
            RobotFileError: If the free joint, a joint or its motor is missing.
        """
        self._scene = scene_file(robot)
        free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
        if len(free) != 1:
            raise RobotFileError(
                self._scene, "freejoint", f"there are {len(free)} free joints", "exactly one"
            )
        self.base_body = int(model.jnt_bodyid[free[0]])
        self._q_base = int(model.jnt_qposadr[free[0]])
        self._v_base = int(model.jnt_dofadr[free[0]])
        joints = [self._joint(model, name) for name in robot.joint_names]
        self._refuse_others(model, {int(free[0]), *joints})
        self._q_joints = np.array([model.jnt_qposadr[joint] for joint in joints])
        self.v_joints = np.array([model.jnt_dofadr[joint] for joint in joints])
        self.actuators = np.array(
            [
                self._motor(model, joint, name)
                for joint, name in zip(joints, robot.joint_names, strict=True)
            ]
        )
        # where MuJoCo keeps what comes one after the other in q and in v
        b, w = self._q_base, self._v_base
        base = [b, b + 1, b + 2, *(b + 3 + i for i in WXYZ_TO_XYZW)]
        self._q_places = np.array([*base, *self._q_joints])
        self._v_places = np.array([*range(w, w + 6), *self.v_joints])

    def read(self, data: Any) -> State:
        """Read the state of ``mujoco.MjData`` in Pinocchio's conventions."""
        qpos, b = data.qpos, self._q_base
        q, v = qpos[self._q_places], data.qvel[self._v_places]
        mujoco.mju_rotVecQuat(v[:3], v[:3].copy(), qpos[b + 3 : b + 7] * CONJUGATE)
        return State(q, v)

    def write(self, data: Any, state: State) -> None:
        """Set the state of ``mujoco.MjData`` from one in Pinocchio's conventions."""
        b, w = self._q_base, self._v_base
        data.qpos[b : b + 3] = state.q[:3]
        data.qpos[b + 3 : b + 7] = state.q[3:7][XYZW_TO_WXYZ]
        data.qpos[self._q_joints] = state.q[7:]
        linear = np.empty(3)
        mujoco.mju_rotVecQuat(linear, state.v[:3], data.qpos[b + 3 : b + 7])
        data.qvel[w : w + 3] = linear
        data.qvel[w + 3 : w + 6] = state.v[3:6]
        data.qvel[self.v_joints] = state.v[6:]

    def velocity_transform(self, state: State) -> Matrix:
        """Compute T with v_pinocchio = T v_mujoco, (nv, nv)."""
        size = len(state.v)
        T = np.zeros((size, size))
        b = self._v_base
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, state.q[3:7][XYZW_TO_WXYZ])
        T[:3, b : b + 3] = rotation.reshape(3, 3).T
        T[3:6, b + 3 : b + 6] = np.eye(3)
        T[6 + np.arange(size - 6), self.v_joints] = 1.0
        return T

    @staticmethod
    def transform_drift(state: State) -> Vector:
        """Compute dT/dt v_mujoco: the base frame turns under the linear velocity, (nv,)."""
        drift = np.zeros(len(state.v))
        drift[:3] = -np.cross(state.v[3:6], state.v[:3])
        return drift

    def _joint(self, model: Any, name: str) -> int:
        joint = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name))
        if joint < 0:
            names = ", ".join(model.joint(i).name for i in range(model.njnt))
            raise RobotFileError(
                self._scene, f"joint {name}", "is missing", f"the URDF's joints (there are {names})"
            )
        return joint

    def _motor(self, model: Any, joint: int, name: str) -> int:
        found = [
            i
            for i in range(model.nu)
            if model.actuator_trnid[i, 0] == joint
            and model.actuator_trntype[i] == mujoco.mjtTrn.mjTRN_JOINT
        ]
        if len(found) != 1 or not _is_motor(model, found[0]):
            raise RobotFileError(
                self._scene,
                f"actuator of joint {name}",
                f"there are {len(found)}" if len(found) != 1 else "is no plain motor",
                "exactly one <motor> with gear 1, which applies its control as torque",
            )
        return found[0]

    def _refuse_others(self, model: Any, known: set[int]) -> None:
        others = [model.joint(i).name or f"number {i}" for i in range(model.njnt) if i not in known]
        if others:
            raise RobotFileError(
                self._scene,
                f"joint {', '.join(others)}",
                "is not in the URDF",
                "the same joints in both, fixed ones left out",
            )


def _is_motor(model: Any, actuator: int) -> bool:
    return bool(
        model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED
        and model.actuator_gainprm[actuator, 0] == 1.0
        and model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE
        and model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_NONE
        and model.actuator_gear[actuator, 0] == 1.0
    )
