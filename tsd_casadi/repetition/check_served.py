"""Looks again at what a learner served, before a robot moves with it."""

from __future__ import annotations

from tsd_casadi.exceptions import IncompatibleEntry
from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.learning.bound import ALLOWED, Bound, peak
from tsd_casadi.learning.context import UNKNOWN
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.allowed_acceleration import allowed_accelerations
from tsd_casadi.robot.robot import Robot

# of a bound: what writing numbers down and reading them may change
ROUNDING = 1e-6


def check_served(feedforward: Feedforward, robot: Robot, motion: Motion) -> None:
    """Refuse a feedforward that is not for a robot, or is not what its learner says of it.

    What nobody wrote down, as in entries of old files, is not held against it.

    Args:
        robot: As its controller believes it.
        motion: That it will be used for.

    Raises:
        IncompatibleEntry: If robot, axes, body or formulation are others, or the
            feedforward is no number, or beyond its bound or what the torque limits
            allow at the motion.
    """
    told = feedforward.provenance
    context = told.get("context") or {}
    for name, served, ours in (
        ("robot", told.get("robot"), robot.name),
        ("body", context.get("body"), robot.body_fingerprint),
        ("formulation", context.get("formulation"), robot.formulation_fingerprint),
    ):
        if served not in (None, UNKNOWN, ours):
            raise IncompatibleEntry(
                f"the feedforward served is of another {name}, {served}; the robot that would "
                f"move has {ours}. Learn again on this one, or ask with its context"
            )
    known = {f"{part.name}.{axis}" for part in robot.description.tasks for axis in part.axes}
    for axis in feedforward.axes:
        if axis not in known:
            raise IncompatibleEntry(
                f"the feedforward served is along {axis}, which {robot.name} does not control; "
                f"there are {', '.join(sorted(known))}"
            )
    bound = feedforward.bound
    if bound is None:  # nobody said, but a robot's task has its limits
        bound = Bound.of(feedforward.axes, feedforward.basis, [])
    bounds = [bound]
    if allowed := allowed_accelerations(robot, motion, feedforward.axes):
        bounds.append(Bound(tuple(allowed), ALLOWED))
    reached = peak(feedforward.weights, feedforward.basis)
    for each in bounds:
        for axis, value, limit in zip(feedforward.axes, reached, each.largest, strict=True):
            # NaN is not within either
            if not value <= limit * (1 + ROUNDING):
                unit = unit_of_axis(axis)
                raise IncompatibleEntry(
                    f"the feedforward served reaches {value:.3g} {unit}/s^2 along {axis}, more "
                    f"than {limit:.3g}, {each.reason}; forget the entry or see what was recorded"
                )
