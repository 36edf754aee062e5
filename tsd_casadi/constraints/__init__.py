"""The inequalities of section III of the paper, one module each."""

from tsd_casadi.constraints.center_of_pressure import center_of_pressure
from tsd_casadi.constraints.friction import friction
from tsd_casadi.constraints.joint_acceleration import joint_acceleration
from tsd_casadi.constraints.joint_torque import joint_torque
from tsd_casadi.constraints.normal_torque import normal_torque
from tsd_casadi.constraints.unilateral_force import unilateral_force

__all__ = [
    "center_of_pressure",
    "friction",
    "joint_acceleration",
    "joint_torque",
    "normal_torque",
    "unilateral_force",
]
