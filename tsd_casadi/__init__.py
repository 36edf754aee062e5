"""Whole-body control that learns task-specific dynamics.

A robot's files become a symbolic task-space inverse dynamics QP, compiled to C
(``compile_controller``); what its feedback had to add is learned and added as
feedforward (``Database``), after Gams, Mason, Ude, Schaal and Righetti,
"Learning Task-Specific Dynamics to Improve Whole-Body Control".
"""

from tsd_casadi.command import Command
from tsd_casadi.controller import Controller, WholeBodyController, compile_controller
from tsd_casadi.database import Database
from tsd_casadi.exceptions import TsdError
from tsd_casadi.feedforward import Feedforward
from tsd_casadi.inverse_dynamics import InverseDynamics
from tsd_casadi.motions import Motion, Squat
from tsd_casadi.periodic_basis import PeriodicBasis
from tsd_casadi.robot import Robot, load_robot
from tsd_casadi.state import State
from tsd_casadi.tick import Tick
from tsd_casadi.tick_format import Status

__version__ = "0.1.0"

__all__ = [
    "Command",
    "Controller",
    "Database",
    "Feedforward",
    "InverseDynamics",
    "Motion",
    "PeriodicBasis",
    "Robot",
    "Squat",
    "State",
    "Status",
    "Tick",
    "TsdError",
    "WholeBodyController",
    "compile_controller",
    "load_robot",
]
