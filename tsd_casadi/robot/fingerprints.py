"""Hashes of what has to be the same for entries of a database to be comparable."""

from __future__ import annotations

import hashlib
import json
from typing import Any

import numpy as np

from tsd_casadi.robot.robot_file import RobotFile
from tsd_casadi.robot.robot_file_sections import Contact
from tsd_casadi.robot.robot_file_tasks import AnyTask, ComTaskFile, ContactForceFile

# changed whenever the terms of the cost or the equalities change their meaning
FORMULATION = 1
# of a number that count: the same robot written down by another program is the same
DIGITS = 10


def body_fingerprint(model: Any, base_orientation: tuple[float, float, float]) -> str:
    """Hash kinematics, masses and inertias.

    Args:
        model: ``pinocchio.Model``.
        base_orientation: Roll, pitch and yaw of the base where the robot stands [rad].

    Returns:
        16 hexadecimal digits.
    """
    numbers = [
        *([base_orientation] if any(base_orientation) else []),
        *(inertia.toDynamicParameters() for inertia in model.inertias),
        *(placement.homogeneous.ravel() for placement in model.jointPlacements),
        model.gravity.linear,
    ]
    digest = hashlib.sha256()
    for joint, name in zip(model.joints, model.names, strict=True):
        digest.update(f"{name} {joint.shortname()}\0".encode())
    for values in numbers:
        # minus zero is zero
        digest.update((np.round(np.asarray(values, dtype=float), DIGITS) + 0.0).tobytes())
    return digest.hexdigest()[:16]


def formulation_fingerprint(described: RobotFile) -> str:
    """Hash tasks, contacts and cost terms, not gains, limits or ranges.

    Returns:
        16 hexadecimal digits.
    """
    meaning = [
        FORMULATION,
        [_meaning_of_task(task) for task in described.all_tasks],
        [_meaning(contact) for contact in described.contacts],
        [described.posture.W, described.regularization.model_dump()],
    ]
    return hashlib.sha256(json.dumps(meaning).encode()).hexdigest()[:16]


def _meaning_of_task(task: AnyTask) -> tuple[object, ...]:
    """Tell what a task means to the formulation."""
    if isinstance(task, ContactForceFile):
        return (task.type, task.name, task.contact, task.axes, task.W, task.active)
    meaning: tuple[object, ...] = (task.type, task.name, getattr(task, "frame", ""), task.axes)
    sometimes = not isinstance(task, ComTaskFile) and not task.active
    return (*meaning, task.W, "sometimes") if sometimes else (*meaning, task.W)


def _meaning(contact: Contact) -> tuple[object, ...]:
    """Tell what a contact means to the formulation, for a sole at a frame just its names."""
    meaning: tuple[object, ...] = (contact.name, contact.frame)
    if contact.offset is not None:
        meaning += (contact.offset.xyz, contact.offset.rpy)
    return meaning if contact.type == "sole" else (*meaning, contact.type)
