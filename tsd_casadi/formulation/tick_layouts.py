"""What a tick's request and reply hold, field by field, for people and on the wire."""

from __future__ import annotations

from collections.abc import Sequence

from tsd_casadi.formulation.contact import WRENCH, Contact
from tsd_casadi.formulation.limit_fields import limit_fields
from tsd_casadi.robot.robot import Robot
from tsd_casadi.tasks.contact_force_task import ContactForceTask
from tsd_casadi.tasks.task import Task
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.layout import Field, Layout

EXPLAIN = Field(
    "explain",
    1,
    "1",
    "whether a tick without a solution says in conflict which limits cannot hold together",
    lower=0.0,
    upper=1.0,
    default=(0.0,),
    switch=True,
)


def tick_format(
    robot: Robot,
    tasks: Sequence[Task],
    contacts: Sequence[Contact],
    request: Layout,
    row_names: tuple[str, ...],
) -> TickFormat:
    """Put together what is known of a problem's request and reply."""
    return TickFormat(
        robot=robot.name,
        joints=tuple(robot.joint_names),
        contacts=tuple(contact.name for contact in contacts),
        axes=tuple((task.name, axis) for task in tasks for axis in task.axes),
        row_names=row_names,
        request=request,
        reply=reply_layout(robot, tasks, contacts, row_names),
    )


def request_layout(
    robot: Robot,
    tasks: Sequence[Task],
    contacts: Sequence[Contact],
    forces: Sequence[ContactForceTask] = (),
) -> Layout:
    """Lay out state and command.

    Everything a user may change between two ticks is in here, so that the
    compiled function has no memory.

    Returns:
        Fields q, v, then tasks, contacts, posture, weights and limits.
    """
    state = (
        Field(
            "q",
            robot.nq,
            "m, 1, rad",
            "base position (world), base quaternion xyzw, joints",
            default=tuple(robot.home.q),
            unit_quaternion=3,
        ),
        Field(
            "v",
            robot.nv,
            "m/s, rad/s",
            "base linear and angular velocity (base frame), joints",
            default=tuple(robot.home.v),
        ),
    )
    task_fields = [field for task in tasks for field in task.fields(robot)]
    contact_fields = [field for contact in contacts for field in contact.fields(robot)]
    force_fields = [field for force in forces for field in force.fields()]
    joint_fields = (*_joint_fields(robot), *limit_fields(robot))
    return Layout((*state, *task_fields, *contact_fields, *force_fields, *joint_fields, EXPLAIN))


def _joint_fields(robot: Robot) -> tuple[Field, ...]:
    n = robot.n
    posture = robot.description.posture
    return (
        Field("posture.q_ref", n, "rad", "joint angles", default=tuple(robot.home.q[7:])),
        Field("posture.P", n, "1/s^2", "stiffness P_q", lower=0.0, default=(posture.P,) * n),
        Field("posture.D", n, "1/s", "damping D_q", lower=0.0, default=(posture.D,) * n),
        Field(
            "posture.W",
            robot.nv,
            "1",
            "diagonal of W_q, base and joints",
            lower=0.0,
            default=(posture.W,) * robot.nv,
        ),
        Field(
            "regularization.acceleration",
            1,
            "1",
            "weight of all accelerations about zero",
            lower=0.0,
            default=(robot.description.regularization.acceleration,),
        ),
        Field(
            "safe_torque.D",
            n,
            "N m s/rad",
            "damping of the torque that answers a failed solve",
            lower=0.0,
            default=(robot.description.safe_torque.D,) * n,
        ),
    )


def reply_layout(
    robot: Robot, tasks: Sequence[Task], contacts: Sequence[Contact], row_names: Sequence[str]
) -> Layout:
    """Lay out what a tick answers.

    Args:
        tasks: The Cartesian tasks, in the order of error and feedback.
        contacts: The contacts, in the order of the wrenches.

    Returns:
        Status and times, torque, acceleration, wrenches, task errors and
        feedback, active rows and those that contradict each other.
    """
    k = sum(task.k for task in tasks)
    axes = " ".join(f"{task.name}.{axis}" for task in tasks for axis in task.axes)
    return Layout(
        (
            Field("status", 1, "1", "0 ok, else the kind of failure"),
            Field("iterations", 1, "1", "iterations of the solver"),
            Field("data_time", 1, "us", "time to evaluate the QP's data"),
            Field("factorization_time", 1, "us", "time to factorise"),
            Field("solve_time", 1, "us", "time to solve"),
            Field("tau", robot.n, "N m", "joint torques; the safe torque on failure"),
            Field("qdd", robot.nv, "m/s^2, rad/s^2", "accelerations, as v; zero on failure"),
            Field(
                "wrenches",
                WRENCH * len(contacts),
                "N, N m",
                f"[force; moment] in {_wrench_axes(contacts)}; zero on failure",
            ),
            Field("error", k, _error_unit(tasks), f"x_ref - x along {axes}, world axes"),
            Field("feedback", k, "m/s^2, rad/s^2", f"P e + D de/dt along {axes}, world axes"),
            Field(
                "active",
                len(row_names),
                "1",
                "per row: 0 inside, 2 equality, 9 one that follows from others or nearly so, "
                "otherwise negative at its lower bound and "
                "positive at its upper: 1 its own; of a joint's acceleration also 4 that by its "
                "position, 5 by its velocity, 3 where one of these two yielded, 7 past its "
                "position's limit and coming back faster than it has to, 8 past its velocity's; "
                "of a joint's torque also 6 what its motor has left at its speed",
            ),
            Field(
                "conflict",
                len(row_names),
                "m/s^2, rad/s^2, N, N m",
                "if explain was asked for and the tick is infeasible: by how much each row of a "
                "set that cannot hold together would have to give way alone, negative at its "
                "lower bound; without any one of them the others can hold. Else 0",
            ),
        )
    )


def _error_unit(tasks: Sequence[Task]) -> str:
    others = [task.error_unit for task in tasks if task.error_unit not in ("m", "rad", "m, rad")]
    return ", ".join(("m", "rad", *dict.fromkeys(others)))


def _wrench_axes(contacts: Sequence[Contact]) -> str:
    """Say which contacts' wrenches are in which axes."""
    names: dict[str, list[str]] = {}
    for contact in contacts:
        names.setdefault(contact.reply_axes, []).append(contact.name)
    return ", in ".join(f"{axes} {' '.join(listed)}" for axes, listed in names.items())
