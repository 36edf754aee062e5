"""One humanoid, from its description to a learned squat."""

from __future__ import annotations

from pathlib import Path
from time import process_time
from typing import Any

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.examination.examine import examine
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.motions.motion import declared_parameters
from tsd_casadi.motions.ranges import range_of
from tsd_casadi.motions.squat import Squat
from tsd_casadi.proposal.propose import propose_robot_file
from tsd_casadi.repetition.learn import learn
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_experiments.harness.learn_case import own_database

FREQUENCY = 0.25  # Hz
MODEL_ERROR = 0.1
ITERATIONS = 2


def propose(
    source: Path, feet: tuple[str, str], locks: tuple[str, ...], name: str, folder: Path
) -> Path:
    """Write the robot file that is proposed for a description, nothing edited.

    Args:
        folder: Where to.

    Returns:
        The robot file.
    """
    robot_file = folder / f"{name}.yaml"
    robot_file.write_text(propose_robot_file(source, feet, locks, name, robot_file).text)
    return robot_file


def learn_squat(robot_file: str, rules: tuple[RuleName, ...], amplitude: float | None) -> Any:
    """Learn a squat with some rules.

    Args:
        robot_file: Or the name of a shipped robot.
        amplitude: [m]; the largest that the robot file allows if left out.

    Returns:
        Plain data: amplitude, seconds of CPU to load and check, errors that the check
        found, whether a run fell, and by rule RMS and AC errors of each run [m].
    """
    robot = load_robot(robot_file)
    controller = compile_controller(robot)  # in the cache from here on
    start = process_time()
    robot = load_robot(robot_file)
    findings = examine(robot, compile_controller(robot)).findings
    seconds = process_time() - start
    amplitude = _largest(robot) if amplitude is None else amplitude
    squat = Squat(amplitude, FREQUENCY)
    result: dict[str, Any] = {
        "joints": robot.n,
        "amplitude": amplitude,
        "check_seconds": seconds,
        "errors": [finding.element for finding in findings if finding.severity == "error"],
        "fell": False,
    }
    for rule in rules:
        with own_database() as database:
            runs = learn(
                MujocoSimulator(robot, MODEL_ERROR),
                controller,
                [squat],
                database,
                axes=squat.axes(robot),
                iterations=ITERATIONS,
                rule=rule,
            )
        result["fell"] |= any(run.fell for run in runs)
        errors = [run.errors[run.axes[0]] for run in runs]
        result[rule] = {
            "rms": [error.rms for error in errors],
            "ac": [error.ac_rms for error in errors],
        }
    return result


def _largest(robot: Robot) -> float:
    (amplitude,) = (x for x in declared_parameters(Squat) if x.name == "amplitude")
    return range_of(robot, Squat, amplitude)[1]
