"""State and command of a tick, put together again from a log."""

from __future__ import annotations

import numpy as np
import pinocchio

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.motions.hold import hold
from tsd_casadi.robot.robot_file_sections import FRAME_AXES
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.format import Status
from tsd_clients.logs.log import Log

WHOLE = "state and command as the controller got them"
ASSUMED = (
    "the true state in 32 bits, where the controller was told the measured one",
    "limits, weights, contacts and gains of the robot file",
    "the home posture in the null space, where the run had the middle of its motion",
)


def first_tick(log: Log) -> int:
    """Choose the first tick that failed, the last one if none did."""
    failed = np.flatnonzero(log.fields["status"] > Status.OK)
    return int(failed[0]) if len(failed) else len(log.fields["status"]) - 1


def logged_request(log: Log, tick: int, problem: InverseDynamics) -> tuple[Vector, tuple[str, ...]]:
    """Put the request of a tick together.

    Exact for the first tick without a solution, where the log has it. Otherwise
    what tasks were to accelerate is what the log says (along axes of the repetition
    feedforward, feedback and the second difference of the reference, at the ends of
    the log the neighbour's; along others the feedback of what the error was), the
    rest is the robot file's.

    Args:
        tick: From 0 on.

    Returns:
        The request, (request.size,), and what it rests upon, in words.

    Raises:
        InvalidValue: If the log has no such tick, it had no answer, or the log is of
            another robot.
    """
    fields, robot = log.fields, problem.robot
    count = len(fields["status"])
    if not 0 <= tick < count:
        raise InvalidValue("tick", tick, f"one of 0 to {count - 1}, as many as the log has")
    if fields["missed"][tick]:
        raise InvalidValue("tick", f"{tick}, which had no answer", "one that the controller saw")
    _check_robot(log, problem)
    if (
        log.infeasible_request is not None
        and log.infeasible_request.shape == (problem.request.size,)
        and tick == int(np.argmax(fields["status"] == Status.INFEASIBLE))
    ):
        return log.infeasible_request, (WHOLE,)
    command = Command(problem.request)
    hold(command, robot, robot.home)
    q = fields["q"][tick].astype(float)
    q[3:7] /= np.linalg.norm(q[3:7])
    command.set_state(State(q, fields["v"][tick].astype(float)))
    first = 0
    for task in problem.tasks:
        error = dict(zip(task.axes, fields["all_errors"][tick][first:], strict=False))
        first += task.k
        offset = np.array([float(error.get(axis, 0.0)) for axis in FRAME_AXES])
        if f"{task.name}.reference" not in command.fields:
            continue  # nowhere to be
        if len(command[f"{task.name}.reference"]) == 3:
            command[f"{task.name}.reference"] = robot.center_of_mass(q) + offset[:3]
        else:
            position, quaternion = robot.frame_placement(robot.frame_name(task.name), q)
            R = pinocchio.exp3(offset[3:]) @ pinocchio.Quaternion(quaternion).matrix()
            turned = pinocchio.Quaternion(R).coeffs()
            command[f"{task.name}.reference"] = np.concatenate((position + offset[:3], turned))
    for task_name in {axis.rpartition(".")[0] for axis in log.axes}:
        command[f"{task_name}.active"] = 1.0
    _add_accelerations(log, tick, problem, command)
    return command.request, ASSUMED


def _check_robot(log: Log, problem: InverseDynamics) -> None:
    robot = problem.robot
    if log.robot not in ("", robot.name):
        raise InvalidValue("robot", f"'{robot.name}'", f"'{log.robot}', whose log this is")
    if log.model not in ("", robot.fingerprint):
        raise InvalidValue(
            "model of the robot's files",
            f"{robot.fingerprint} ({robot.path})",
            f"{log.model}, as in the log; name the files it was made with by --robot",
        )
    k = sum(task.k for task in problem.tasks)
    found = tuple(log.fields[name].shape[1] for name in ("q", "v", "all_errors"))
    if found != (robot.nq, robot.nv, k):
        raise InvalidValue(
            "the log's q, v and errors",
            f"of sizes {found}",
            f"those of {robot.name}, {(robot.nq, robot.nv, k)}; name its robot with --robot",
        )


def _add_accelerations(log: Log, tick: int, problem: InverseDynamics, command: Command) -> None:
    """Make the tasks of the repetition ask for what they asked for then.

    What comes from rates of the reference, which the log has not, is put into the
    feedforward.
    """
    time, reference = log.fields["time"], log.fields["reference"]
    xdd = np.zeros(len(log.axes))
    if len(time) > 2:
        middle = min(max(tick, 1), len(time) - 2)
        period = time[middle] - time[middle - 1]
        xdd = (reference[middle + 1] - 2 * reference[middle] + reference[middle - 1]) / period**2
    terms = problem.terms
    here = np.array(terms(command.request)[terms.index_out("feedback")])[:, 0]
    for place, axis in enumerate(log.axes):
        task, _, name = axis.rpartition(".")
        feedback = log.fields["feedback"][tick, place]
        lacking = feedback - here[problem.format.axis_index(task, name)]
        command[f"{task}.feedforward"][problem.format.component_index(task, name)] = (
            log.fields["feedforward"][tick, place] + xdd[place] + lacking
        )
