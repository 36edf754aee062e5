"""What a controller answers at one tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsd_casadi.state import Vector
from tsd_casadi.tick.format import Status, TickFormat
from tsd_casadi.tick.row_state import NO_INEQUALITY, RowState, name_row


@dataclass(frozen=True)
class Tick:
    """A reply, read by name.

    Attributes:
        format: The meaning of its numbers.
        reply: The reply vector, (format.reply.size,).
    """

    format: TickFormat
    reply: Vector

    def __repr__(self) -> str:
        """Say how the tick ended and what it asks for."""
        largest = float(np.abs(self.tau).max(initial=0.0))
        return (
            f"<Tick of {self.format.robot}: {self.status.name.lower()}, torques up to "
            f"{largest:.1f} N m, {len(self.active)} rows active, {self.compute_time:.0f} us>"
        )

    def _field(self, name: str) -> Vector:
        return self.reply[self.format.reply.slices[name]]

    @property
    def status(self) -> Status:
        """How the tick ended; on everything but OK, tau is the safe torque."""
        return Status(int(self.reply[0]))

    @property
    def iterations(self) -> int:
        """Iterations of the solver."""
        return int(self._field("iterations")[0])

    @property
    def tau(self) -> Vector:
        """Joint torques, (n,) [N m]."""
        return self._field("tau")

    @property
    def qdd(self) -> Vector:
        """Accelerations in the convention of v, (nv,) [m/s^2, rad/s^2]."""
        return self._field("qdd")

    @property
    def wrenches(self) -> dict[str, Vector]:
        """Wrench [force; moment] by contact, (6,) [N, N m].

        In the sole frame; of a point in world axes, its moment zero.
        """
        wrenches = self._field("wrenches").reshape(-1, 6)
        return dict(zip(self.format.contacts, wrenches, strict=True))

    @property
    def error(self) -> Vector:
        """x_ref - x of all tasks as the controller sees it, (k,) [m, rad]."""
        return self._field("error")

    @property
    def feedback(self) -> Vector:
        """P e + D de/dt of all tasks, (k,) [m/s^2, rad/s^2]."""
        return self._field("feedback")

    @property
    def active(self) -> list[str]:
        """Names of the inequality rows at one of their bounds, or beyond because they yielded.

        A joint's row that is there by its position or velocity has that in its name:
        'joint_position.knee'.
        """
        state = np.abs(self._field("active")).astype(int)
        places = np.flatnonzero(~np.isin(state, NO_INEQUALITY))
        return [name_row(self.format.row_names[i], RowState(state[i])) for i in places]

    @property
    def yielded(self) -> list[str]:
        """Names of the joints' rows whose limits of position or velocity yielded."""
        state = np.abs(self._field("active"))
        return [self.format.row_names[i] for i in np.flatnonzero(state == RowState.YIELDED)]

    @property
    def conflict(self) -> dict[str, float]:
        """Limits that cannot hold together, if the command asked for them with 'explain'.

        By name, by how much each would have to give way if it alone did, in its own unit
        and negative at its lower bound. Without any one of them the others can hold.
        """
        amounts = self._field("conflict")
        return {self.format.row_names[i]: float(amounts[i]) for i in np.flatnonzero(amounts)}

    @property
    def compute_time(self) -> float:
        """Time inside the compiled function [us]."""
        return float(self.reply[2] + self.reply[3] + self.reply[4])
