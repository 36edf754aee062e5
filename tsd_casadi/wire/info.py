"""What a controller says of itself."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from tsd_casadi.document import Document
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.tick.format import STATUS_MEANING, TickFormat
from tsd_casadi.tick.layout import Field as LayoutField
from tsd_casadi.tick.layout import Layout
from tsd_casadi.wire.message import Message


class FieldMessage(Document):
    """One field of a layout.

    Attributes:
        name: Dotted name.
        offset: First float64.
        size: Number of float64.
        unit: SI unit.
        description: Meaning.
        lower: Smallest accepted value.
        upper: Largest accepted value.
        default: Values at home; empty in a reply's layout.
        unit_quaternion: Index in the field where a unit quaternion starts.
        switch: Whether only 0 and 1 are accepted.
    """

    name: str
    offset: Annotated[int, Field(ge=0)]
    size: Annotated[int, Field(ge=1, le=100_000)]
    unit: str
    description: str
    lower: float
    upper: float
    default: tuple[float, ...]
    unit_quaternion: int | None
    switch: bool


def _field_messages(layout: Layout) -> list[FieldMessage]:
    return [
        FieldMessage(
            offset=layout.slice(part.name).start,
            **{name: getattr(part, name) for name in FieldMessage.model_fields if name != "offset"},
        )
        for part in layout
    ]


def _layout(fields: list[FieldMessage]) -> Layout:
    layout = Layout(tuple(LayoutField(**part.model_dump(exclude={"offset"})) for part in fields))
    for part in fields:
        start = layout.slice(part.name).start
        if part.offset != start or len(part.default) not in (0, part.size):
            raise MalformedMessage(
                f"field {part.name} at {part.offset}, {len(part.default)} defaults",
                f"it at {start}, with {part.size} defaults or none",
            )
    return layout


class InfoMessage(Message):
    """What a controller is: enough to pack a tick without this software.

    Attributes:
        format: Name and version of this message.
        robot: Name of the robot.
        version: Version of the software.
        instance: Id of the service, as in every reply.
        protocol: Version of the tick's header.
        layout_hash: For the tick's header, hexadecimal.
        model: Fingerprint of the robot description.
        body: Fingerprint of kinematics, masses and inertias, as in a context.
        formulation: Fingerprint of tasks, contacts and cost terms, as in a context.
        joints: Actuated joints, in the order of q, v and tau.
        contacts: Contacts, in the order of the wrenches.
        axes: (task, axis) in the order of error and feedback.
        row_names: Rows of the QP, in the order of active.
        statuses: Meaning of the reply's status.
        request: Fields of a request.
        reply: Fields of a reply.
        ticks_served: Ticks answered with a torque since the service started.
        ticks_refused: Ticks answered with an error.
    """

    format: Literal["tsd.info/2"] = "tsd.info/2"
    robot: str
    version: str
    instance: int
    protocol: int
    layout_hash: str
    model: str
    body: str
    formulation: str
    joints: tuple[str, ...]
    contacts: tuple[str, ...]
    axes: tuple[tuple[str, str], ...]
    row_names: tuple[str, ...]
    statuses: dict[str, str]
    request: list[FieldMessage]
    reply: list[FieldMessage]
    ticks_served: int
    ticks_refused: int

    @classmethod
    def of(
        cls,
        tick_format: TickFormat,
        *,
        version: str,
        instance: int,
        protocol: int,
        model: str,
        body: str,
        formulation: str,
        ticks_served: int,
        ticks_refused: int,
    ) -> InfoMessage:
        """Describe a controller."""
        return cls(
            robot=tick_format.robot,
            version=version,
            instance=instance,
            protocol=protocol,
            layout_hash=f"{tick_format.layout_hash:016x}",
            model=model,
            body=body,
            formulation=formulation,
            joints=tick_format.joints,
            contacts=tick_format.contacts,
            axes=tick_format.axes,
            row_names=tick_format.row_names,
            statuses={str(int(status)): text for status, text in STATUS_MEANING.items()},
            request=_field_messages(tick_format.request),
            reply=_field_messages(tick_format.reply),
            ticks_served=ticks_served,
            ticks_refused=ticks_refused,
        )

    def tick_format(self) -> TickFormat:
        """Tell what the numbers of requests and replies mean."""
        return TickFormat(
            robot=self.robot,
            joints=self.joints,
            contacts=self.contacts,
            axes=self.axes,
            row_names=self.row_names,
            request=_layout(self.request),
            reply=_layout(self.reply),
        )
