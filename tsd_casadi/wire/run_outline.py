"""What a repetition that can be watched says of itself before its first tick."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from tsd_casadi.document import Document
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.layout import Layout
from tsd_casadi.tick.row_layout import row_layout


class RunOutline(Document):
    """Everything that a viewer or a log needs to read the rows of a repetition.

    Attributes:
        format: Name and version of this document.
        robot: Name of the robot.
        robot_file: Where its robot file is on the machine of the run.
        model: Fingerprint of the robot's files.
        motion: Name of the motion.
        version: Of the motion.
        parameters: Of the motion, by name.
        axes: 'task.axis' of all axes of the repetition.
        learned: The first so many of them are learned.
        period: Control period [s].
        nq: Size of the configuration.
        torque_limits: By joint [N m].
        controller: Meaning of the controller's request and reply, as ``TickFormat.plain``.
    """

    format: Literal["tsd.run-outline/1"] = "tsd.run-outline/1"
    robot: str
    robot_file: str
    model: str
    motion: str
    version: str
    parameters: dict[str, float]
    axes: tuple[str, ...]
    learned: Annotated[int, Field(ge=0)]
    period: Annotated[float, Field(gt=0)]
    nq: Annotated[int, Field(gt=0)]
    torque_limits: tuple[float, ...]
    controller: dict[str, Any]

    @property
    def known(self) -> TickFormat:
        """The meaning of the controller's numbers."""
        return TickFormat.from_plain(self.controller)

    @property
    def layout(self) -> Layout:
        """What the numbers of a row are."""
        return row_layout(self.known, len(self.axes), self.nq)
