"""What the numbers of a tick's request and reply mean."""

from __future__ import annotations

import enum
from dataclasses import asdict, dataclass
from typing import Any

from tsd_casadi.exceptions import UnknownField
from tsd_casadi.tick.layout import Field, Layout, hash_layouts


class Status(enum.IntEnum):
    """How a tick ended.

    On everything but OK the reply carries the safe torque, with accelerations
    and wrenches zero.
    """

    OK = 0
    INFEASIBLE = 1
    ITERATION_LIMIT = 2
    SINGULAR = 3
    NOT_FINITE = 4


STATUS_MEANING = {
    Status.OK: "solved",
    Status.INFEASIBLE: "no acceleration satisfies all rows: the limits contradict each other",
    Status.ITERATION_LIMIT: "the solver did not reach an optimum that keeps the limits",
    Status.SINGULAR: "the cost does not determine the solution: a weight is zero or negative",
    Status.NOT_FINITE: "the numbers overflowed: state or command is absurdly large",
}


@dataclass(frozen=True)
class TickFormat:
    """The meaning of every number in a tick's request and reply.

    Attributes:
        robot: Name of the robot.
        joints: Actuated joints, in the order of q, v and tau.
        contacts: Contacts, in the order of the wrenches.
        axes: (task, axis) in the order of error and feedback.
        row_names: Names of the QP's rows, in the order of active.
        request: Layout of the request.
        reply: Layout of the reply.
    """

    robot: str
    joints: tuple[str, ...]
    contacts: tuple[str, ...]
    axes: tuple[tuple[str, str], ...]
    row_names: tuple[str, ...]
    request: Layout
    reply: Layout

    def summary(self) -> str:
        """Name the robot and the sizes: 'my_robot: 17 joints, 80 rows, ...'."""
        return (
            f"{self.robot}: {len(self.joints)} joints, {len(self.row_names)} rows, request of "
            f"{self.request.size} and reply of {self.reply.size} float64"
        )

    def __repr__(self) -> str:
        """Name the robot and the sizes."""
        return f"<TickFormat of {self.summary()}>"

    @property
    def layout_hash(self) -> int:
        """Fingerprint of both layouts, 64 bits."""
        return hash_layouts([self.request, self.reply])

    def plain(self) -> dict[str, Any]:
        """Write the format as plain data for JSON; ``from_plain`` reads it."""
        layouts = ("request", "reply")
        names = ("robot", "joints", "contacts", "axes", "row_names")
        return {
            **{name: getattr(self, name) for name in names},
            **{name: [asdict(part) for part in getattr(self, name)] for name in layouts},
        }

    @classmethod
    def from_plain(cls, plain: dict[str, Any]) -> TickFormat:
        """Read what ``plain`` wrote, also after a way through JSON."""

        def layout(parts: list[dict[str, Any]]) -> Layout:
            return Layout(
                tuple(Field(**{**part, "default": tuple(part["default"])}) for part in parts)
            )

        return cls(
            robot=plain["robot"],
            joints=tuple(plain["joints"]),
            contacts=tuple(plain["contacts"]),
            axes=tuple((task, axis) for task, axis in plain["axes"]),
            row_names=tuple(plain["row_names"]),
            request=layout(plain["request"]),
            reply=layout(plain["reply"]),
        )

    def axis_index(self, task: str, axis: str) -> int:
        """Tell where a task's axis lies in error and feedback.

        Raises:
            UnknownField: If no task has that axis.
        """
        try:
            return self.axes.index((task, axis))
        except ValueError:
            known = [".".join(pair) for pair in self.axes]
            raise UnknownField(f"{task}.{axis}".lstrip("."), known) from None

    def component_index(self, task: str, axis: str) -> int:
        """Tell where an axis lies in a task's own fields, such as its P.

        Raises:
            UnknownField: If no task has that axis.
        """
        first = next((i for i, pair in enumerate(self.axes) if pair[0] == task), 0)
        return self.axis_index(task, axis) - first
