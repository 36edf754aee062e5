"""What the numbers of a report were made with, and what differs from the paper."""

from __future__ import annotations

import platform
from importlib.metadata import version
from typing import Any

from tsd_casadi.robot.robot import Robot
from tsd_casadi.version import __version__
from tsd_experiments.harness.run_jobs import cores

PACKAGES = ("casadi", "pin", "mujoco", "numpy", "scipy", "scikit-learn", "eclipse-zenoh")
DIFFERENCES = (
    "The robot is a model of ours with the paper's joints: the Sarcos Hermes is not public. Links, "
    "masses, limits and gains are invented from anthropometric tables; the README of the robot's "
    "folder says where each number comes from.",
    "There is no hydraulic actuation and no real robot. Its stand-in is a simulation with joint "
    "friction, rotor inertia, torque lag and delay, encoder steps and noise, differenced "
    "velocities, and a base pose from joint angles with the feet assumed flat. Every number of it "
    "is an assumption, in the section 'hardware' of the robot file.",
    "The paper prints no measured errors, only 'an order of magnitude' and figures: its claims are "
    "compared in words.",
    "The goals are this project's own. They were set beforehand, from a smaller study with another "
    "model of the robot.",
    "One axis is learned, the vertical one of the centre of mass, as in the paper, unless it says "
    "otherwise; 'tsd learn' learns all axes of the centre of mass unless told otherwise.",
    "D of the learned task follows P with the damping ratio of the robot file, except where P / 5 "
    "is said: there D stays as it is.",
    "All repetitions of one experiment start in the same random posture and hear the same sensor "
    "noise, unless it says otherwise.",
    "P_null projects into the null space of all Cartesian tasks and of all contacts, not of the "
    "tasks alone: without the contacts the posture fights their forces, and learning was 8 times "
    "worse.",
    "The cost has one term more: a small weight on the square of all accelerations, "
    "a number in the robot file, which makes the optimum the only one. Gains "
    "and weights are diagonal, a number for each axis, where the paper has matrices.",
    "What is learned from is the mean of laps that are steady: they agree to 1 % of feedback and "
    "feedforward, or they scatter about something that does not drift. The paper does not say "
    "which laps it takes.",
    "Tables name the rule of the learning. 'plain' is the paper's sum; the default of 'tsd learn' "
    "is 'adaptive', which is filtered by the response of the loop and leaves out what is noise; "
    "'tsd demo' keeps to the sum, guarded.",
    "A model error of 10 % means that the controller's masses and inertias are 1.1 times those of "
    "the simulated robot.",
)


def circumstances(robot: Robot, quick: bool) -> dict[str, Any]:
    """Tell what the numbers were made with, plain data."""
    description = robot.description
    return {
        "tsd_casadi": __version__,
        **{name: version(name) for name in PACKAGES},
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "cores": cores(),
        "robot": robot.name,
        "robot_fingerprint": robot.fingerprint,
        "tasks": [task.model_dump(exclude={"type", "frame"}) for task in description.all_tasks],
        "hardware": None if description.hardware is None else description.hardware.model_dump(),
        "seed": "0 for starting posture and sensor noise; other seeds are named in the tables",
        "form": "quick" if quick else "full",
    }
