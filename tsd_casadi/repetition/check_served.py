"""Looks again at what a learner served, before a robot moves with it."""

from __future__ import annotations

import numpy as np

from tsd_casadi.encoding.harmonics import sample_phases
from tsd_casadi.exceptions import IncompatibleEntry
from tsd_casadi.learning.context import UNKNOWN
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.robot.robot import Robot

# of a bound: what writing numbers down and reading them may change
ROUNDING = 1e-6


def check_served(feedforward: Feedforward, robot: Robot) -> None:
    """Refuse a feedforward that is not for a robot, or is not what its learner says of it.

    What nobody wrote down, as in entries of old files, is not held against it.

    Args:
        robot: As its controller believes it.

    Raises:
        IncompatibleEntry: If robot, axes, body or formulation are others, or the
            feedforward is no number or beyond its bound.
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
    largest = np.abs(feedforward.mean(sample_phases())).max(axis=1)
    bound = told.get("bound")
    most = np.full(len(largest), np.inf) if bound is None else np.asarray(bound["largest"])
    if most.shape != largest.shape:
        raise IncompatibleEntry(
            f"the feedforward served has {len(largest)} axes and {most.size} bounds"
        )
    for axis, value, limit in zip(feedforward.axes, largest, most, strict=True):
        if not value <= limit * (1 + ROUNDING) or not np.isfinite(value):
            raise IncompatibleEntry(
                f"the feedforward served reaches {value:.3g} along {axis}, its learner says at "
                f"most {limit:.3g}; forget the entry, or look at what was recorded"
            )
