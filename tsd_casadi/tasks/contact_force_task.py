r"""The task that has a contact carry what it is asked to.

.. math:: \|S \lambda_c - f_{ref}\|^2_{W_s}

S picks components of one contact. Beside ``force_regularization``, which shares the weight
between all contacts and makes the optimum unique, it is meant: pressing with a hand,
unloading a foot. It comes and goes like a task of the accelerations, and what takes over
is the regularisation of the same component.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from tsd_casadi.constraints.rows import BASE_AXES
from tsd_casadi.robot.robot_file_tasks import ContactForceFile
from tsd_casadi.tasks.activation import activation_levels, weight_shares
from tsd_casadi.tasks.task import SHARE, Read
from tsd_casadi.tick.layout import HUGE, Field


@dataclass(frozen=True)
class ForceTerms:
    """What a task of forces adds to the cost of all forces.

    Attributes:
        H: Diagonal, (l,).
        g: (l,).
    """

    H: ca.SX
    g: ca.SX


class ContactForceTask:
    """Some components of one contact's force, in the contact's axes.

    Attributes:
        name: Name of the task, first part of its fields' names.
        contact: Name of its contact.
        axes: Its components, k of them: forces x y z, moments rx ry rz.
    """

    def __init__(self, file: ContactForceFile, wanted: Sequence[float], carried_in: str) -> None:
        """Take it from the robot file.

        Args:
            wanted: What the contact carries at home, the default, (6,) or (3,) [N, N m].
            carried_in: The contact's axes, in words.
        """
        self.name, self.contact, self.axes = file.name, file.contact, file.axes
        self._components = [BASE_AXES.index(axis) for axis in file.axes]
        self._carried_in = carried_in
        self._wanted = tuple(wanted[component] for component in self._components)
        self._W, self._active = file.W, file.active

    @property
    def k(self) -> int:
        """Number of components."""
        return len(self.axes)

    def fields(self) -> tuple[Field, ...]:
        """Describe the command's fields of this task, with the robot's defaults."""
        along = f"{' '.join(self.axes)} of {self.contact}, {self._carried_in}"
        moments = [component >= 3 for component in self._components]
        unit = "N m" if all(moments) else "N, N m" if any(moments) else "N"
        weights, ones = (self._W,) * self.k, (1.0,) * self.k
        track = "1: track the task, 0: leave it out"
        parts = (
            ("reference", unit, f"wanted {along}", self._wanted, (-HUGE, HUGE)),
            ("W", "1", f"weights, {along}", weights, (0.0, HUGE)),
            ("active", "1", track, (float(self._active),), SHARE),
            ("mask", "1", f"share of 'active', {along}", ones, SHARE),
        )
        return tuple(
            Field(f"{self.name}.{name}", len(default), unit, words, *within, default=default)
            for name, unit, words, default, within in parts
        )

    def terms(self, read: Read, selection: ca.SX, W_lambda: ca.SX, there: ca.SX) -> ForceTerms:
        """Write half the term in lambda.

        Args:
            read: Gives a field of the command by name, without the task's.
            selection: (size, l), picks the contact's forces out of lambda.
            W_lambda: Diagonal of the regularisation's weight on all forces, (l,).
            there: The contact's ``active``, which the task goes with.
        """
        S = selection[self._components, :]
        W, level = read("W"), there * activation_levels(read("active"), read("mask"))
        weight = W * weight_shares(level, W, S @ W_lambda)
        return ForceTerms(H=S.T @ weight, g=-S.T @ (weight * read("reference")))
