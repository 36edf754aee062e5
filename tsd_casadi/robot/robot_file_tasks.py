"""The tasks of a robot file: what may stand in each, with units."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Discriminator, Field, Tag

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import nearest
from tsd_casadi.robot.robot_file_sections import (
    COM_AXES,
    FRAME_AXES,
    ROTATIONS,
    Contact,
    Finite,
    Name,
    NonNegative,
    Section,
)
from tsd_casadi.state import Matrix

Gain = float | ArrayLike

# how a gain may be written, by its depth; pydantic puts the words into an error's place
GAIN_KINDS = ("number", "diagonal", "matrix")
# of the largest entry: numbers written with seven digits are symmetric and semidefinite
GAIN_TOLERANCE = 1e-6


def _kind_of_gain(gain: object) -> str:
    if not isinstance(gain, (list, tuple)):
        return "number"
    return "matrix" if any(isinstance(row, (list, tuple)) for row in gain) else "diagonal"


AnyGain = Annotated[
    Annotated[NonNegative, Tag("number")]
    | Annotated[tuple[NonNegative, ...], Tag("diagonal")]
    | Annotated[tuple[tuple[Finite, ...], ...], Tag("matrix")],
    Discriminator(_kind_of_gain),
]


def gain_matrix(gain: Gain, k: int) -> Matrix:
    """Write a gain as a matrix.

    Args:
        gain: A number for all axes, a diagonal (k,) or a matrix (k, k).

    Returns:
        (k, k).
    """
    array = np.asarray(gain, dtype=float)
    if array.ndim == 2:
        return array
    return np.diag(np.broadcast_to(array, k))


def wrong_with_gain(gain: AnyGain, axes: Sequence[str]) -> str | None:
    """Tell what a gain that was read should be instead, None if nothing."""
    k = len(axes)
    shaped = f"one number, {k} of them for the axes {' '.join(axes)}, or {k} rows of {k}"
    if isinstance(gain, (int, float)):
        return None
    if len(gain) != k or any(isinstance(row, tuple) and len(row) != k for row in gain):
        return shaped
    matrix = gain_matrix(gain, k)
    tolerance = GAIN_TOLERANCE * np.abs(matrix).max(initial=0.0)
    if np.abs(matrix - matrix.T).max(initial=0.0) > tolerance:
        return "a symmetric matrix"
    if np.linalg.eigvalsh(matrix).min(initial=0.0) < -tolerance:
        return "a matrix without negative eigenvalues: others push away from the reference"
    return None


class ComTaskFile(Section):
    """Centre-of-mass task: gains and weights, world axes.

    Attributes:
        type: Always 'com'.
        name: Name of the task.
        axes: Controlled axes.
        P: Stiffness [1/s^2]: a number, one for each axis, or a symmetric matrix by rows.
        D: Damping [1/s], as P.
        W: Weight [(m/s^2)^-2].
    """

    type: Literal["com"]
    name: Name
    axes: tuple[Literal["x", "y", "z"], ...] = COM_AXES  # type: ignore[assignment]
    P: AnyGain
    D: AnyGain
    W: NonNegative


class FrameTaskFile(Section):
    """Task on a frame of the URDF: gains and weights, world axes.

    Attributes:
        type: Always 'frame'.
        name: Name of the task.
        frame: The frame.
        axes: Controlled axes, translations x y z and rotations rx ry rz.
        P: Stiffness [1/s^2]: a number, one for each axis, or a symmetric matrix by rows.
        D: Damping [1/s], as P.
        W: Weight [(m/s^2)^-2 or (rad/s^2)^-2].
        active: Whether the frame is always tracked; otherwise only in motions that move
            it. A hand that is tracked stays where it is in the world while the rest squats.
    """

    type: Literal["frame"]
    name: Name
    frame: str
    axes: tuple[Literal["x", "y", "z", "rx", "ry", "rz"], ...] = FRAME_AXES  # type: ignore[assignment]
    P: AnyGain
    D: AnyGain
    W: NonNegative
    active: Annotated[bool, Field(strict=True)] = True


class AngularMomentumFile(Section):
    """Task on the angular momentum about the centre of mass, world axes.

    What is tracked is the momentum over the robot's mean inertia at home, an angular
    velocity. It has no place to be at, so no stiffness.

    Attributes:
        type: Always 'angular_momentum'.
        name: Name of the task.
        axes: Controlled axes.
        D: Damping [1/s]: a number, one for each axis, or a symmetric matrix by rows.
        W: Weight [(rad/s^2)^-2].
        active: Whether it always counts; otherwise only where the command says so.
    """

    type: Literal["angular_momentum"]
    name: Name
    axes: tuple[Literal["rx", "ry", "rz"], ...] = ROTATIONS  # type: ignore[assignment]
    D: AnyGain
    W: NonNegative
    active: Annotated[bool, Field(strict=True)] = True


class ContactForceFile(Section):
    """Task on what a contact carries, in the contact's axes.

    Attributes:
        type: Always 'contact_force'.
        name: Name of the task.
        contact: Name of the contact.
        axes: Its components, forces x y z and, of a sole, moments rx ry rz.
        W: Weight [N^-2 or (N m)^-2], beside that of the regularisation.
        active: Whether it always counts; otherwise only where the command says so.
    """

    type: Literal["contact_force"]
    name: Name
    contact: str
    axes: tuple[Literal["x", "y", "z", "rx", "ry", "rz"], ...] = ("z",)
    W: NonNegative
    active: Annotated[bool, Field(strict=True)] = True


# what has a place to be at, so that a posture makes its reference
PlacedTask = ComTaskFile | FrameTaskFile
AnyTask = Annotated[
    ComTaskFile | FrameTaskFile | AngularMomentumFile | ContactForceFile,
    Field(discriminator="type"),
]


def check_tasks(path: Path, tasks: Sequence[AnyTask], contacts: Sequence[Contact]) -> None:
    """Refuse axes and gains that do not fit together.

    Args:
        path: The robot file, for errors.

    Raises:
        RobotFileError: If axes are missing or twice, a gain does not fit them, or a contact
            is unknown or does not carry a component.
    """
    for index, task in enumerate(tasks):
        if not task.axes or len(set(task.axes)) < len(task.axes):
            raise RobotFileError(
                path,
                f"tasks.{index}.axes",
                f"is {list(task.axes)}",
                "at least one axis, none twice",
            )
        for name in ("P", "D"):
            gain = getattr(task, name, 0.0)
            wanted = wrong_with_gain(gain, task.axes)
            if wanted is not None:
                raise RobotFileError(path, f"tasks.{index}.{name}", f"is {gain}", wanted)
        if isinstance(task, ContactForceFile):
            _check_contact(path, index, task, contacts)


def _check_contact(
    path: Path, index: int, task: ContactForceFile, contacts: Sequence[Contact]
) -> None:
    types = {contact.name: contact.type for contact in contacts}
    if task.contact not in types:
        raise RobotFileError(
            path,
            f"tasks.{index}.contact",
            f"'{task.contact}' is no contact of this robot",
            nearest(task.contact, list(types)),
        )
    if types[task.contact] == "point" and not {*task.axes} <= {*COM_AXES}:
        raise RobotFileError(
            path,
            f"tasks.{index}.axes",
            f"is {list(task.axes)} of a point, which carries no moment",
            "some of x, y, z",
        )
