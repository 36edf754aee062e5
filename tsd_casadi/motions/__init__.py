"""Periodic motions: what the robot is asked to do lap after lap."""

from tsd_casadi.motions.motion import Motion, Reference
from tsd_casadi.motions.squat import Squat

__all__ = ["Motion", "Reference", "Squat"]
