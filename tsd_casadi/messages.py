"""The JSON messages of the network, checked where they come in."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import from_json

from tsd_casadi.entry import Entry
from tsd_casadi.exceptions import MalformedMessage, TsdError
from tsd_casadi.feedforward import Feedforward, Kind
from tsd_casadi.laps import Lap
from tsd_casadi.layout import Field as LayoutField
from tsd_casadi.layout import Layout
from tsd_casadi.motions.squat import UNITS
from tsd_casadi.periodic_basis import PeriodicBasis
from tsd_casadi.recording import Context, Recording, TaskKey
from tsd_casadi.tick_format import STATUS_MEANING, TickFormat

Finite = Annotated[float, Field(allow_inf_nan=False, ge=-1e9, le=1e9)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.]*$", max_length=100)]
AnyMessage = TypeVar("AnyMessage", bound="Message")


class Message(BaseModel):
    """A JSON message; unknown fields are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    def encode(self) -> bytes:
        """The message as UTF-8 JSON."""
        return self.model_dump_json().encode()

    @classmethod
    def decode(cls: type[AnyMessage], payload: bytes) -> AnyMessage:
        """Read and check a message.

        Args:
            payload: UTF-8 JSON.

        Raises:
            MalformedMessage: If it is no JSON or a field is wrong.
        """
        try:
            message = cls.model_validate_json(payload)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(map(str, first["loc"])) or "message"
            raise MalformedMessage(
                f"{cls.__name__}: {where}: {first['msg']}", "valid JSON of it"
            ) from error
        try:
            # not even where any value may stand
            from_json(payload, allow_inf_nan=False)
        except ValueError as error:
            raise MalformedMessage(f"{cls.__name__}: {error}", "finite numbers") from error
        return message


class ErrorMessage(Message):
    """Body of an error reply.

    Attributes:
        code: Short machine-readable name.
        message: What was wrong, what was expected, what to do.
    """

    code: str
    message: str

    @classmethod
    def of(cls, error: TsdError) -> ErrorMessage:
        """The message of an error."""
        return cls(code=error.code, message=str(error))


class FieldMessage(Message):
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

    format: Literal["tsd.info/1"] = "tsd.info/1"
    robot: str
    version: str
    instance: int
    protocol: int
    layout_hash: str
    model: str
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
        """The meaning of requests and replies."""
        return TickFormat(
            robot=self.robot,
            joints=self.joints,
            contacts=self.contacts,
            axes=self.axes,
            row_names=self.row_names,
            request=_layout(self.request),
            reply=_layout(self.reply),
        )


class QuantityMessage(Message):
    """A number with its unit."""

    value: Finite
    unit: str


class BasisMessage(Message):
    """A periodic basis, eqs. (basis_functions) and (psi) of the paper.

    Attributes:
        type: Always 'periodic_rbf'.
        L: Number of functions.
        centres: c_j [rad].
        width: h.
    """

    type: Literal["periodic_rbf"] = "periodic_rbf"
    L: Annotated[int, Field(ge=1, le=1000)]
    centres: tuple[Finite, ...]
    width: Annotated[float, Field(gt=0, lt=1e6)]

    @classmethod
    def of(cls, basis: PeriodicBasis) -> BasisMessage:
        """Describe a basis."""
        return cls(L=basis.L, centres=tuple(basis.centres), width=basis.width)

    def basis(self) -> PeriodicBasis:
        """The basis.

        Raises:
            MalformedMessage: If the centres are not 2 pi j / L.
        """
        basis = PeriodicBasis(self.L, self.width)
        if len(self.centres) != self.L or not np.allclose(
            self.centres, basis.centres, rtol=0, atol=1e-9
        ):
            raise MalformedMessage("basis.centres", "2 pi j / L for j = 0 ... L - 1")
        return basis


class FeedforwardMessage(Message):
    """A feedforward term: the project's most public contract.

    Attributes:
        format: Name and version of this message.
        robot: Name of the robot.
        task: Name of the motion.
        axes: Names 'task.axis', k of them, world axes.
        parameters: Task parameters with units.
        unit: Unit of weights and standard deviations.
        basis: The basis.
        weights: k rows of L numbers.
        standard_deviations: Predictive standard deviation of each weight.
        kind: 'learned' or 'generalised'.
        provenance: Entries used, iteration, errors, gains.
    """

    format: Literal["tsd.feedforward/1"] = "tsd.feedforward/1"
    robot: str
    task: str
    axes: Annotated[tuple[str, ...], Field(min_length=1)]
    parameters: dict[str, QuantityMessage]
    unit: Literal["m/s^2"] = "m/s^2"
    basis: BasisMessage
    weights: list[list[Finite]]
    standard_deviations: list[list[Finite]]
    kind: Kind
    provenance: dict[str, Any]

    @classmethod
    def of(cls, robot: str, task: str, feedforward: Feedforward) -> FeedforwardMessage:
        """Describe a feedforward."""
        return cls(
            robot=robot,
            task=task,
            axes=feedforward.axes,
            parameters={
                name: QuantityMessage(value=value, unit=UNITS[name])
                for name, value in feedforward.parameters.items()
            },
            basis=BasisMessage.of(feedforward.basis),
            weights=feedforward.weights.tolist(),
            standard_deviations=feedforward.standard_deviations.tolist(),
            kind=feedforward.kind,
            provenance=feedforward.provenance,
        )

    def feedforward(self) -> Feedforward:
        """The feedforward.

        Raises:
            MalformedMessage: If the shapes do not fit.
        """
        shape = (len(self.axes), self.basis.L)
        for name, quantity in self.parameters.items():
            if quantity.unit != UNITS.get(name):
                raise MalformedMessage(
                    f"parameter {name} in {quantity.unit}",
                    f"{UNITS.get(name, 'no such parameter')}",
                )
        deviations = _matrix("standard_deviations", self.standard_deviations, shape)
        if (deviations < 0).any():
            raise MalformedMessage("a negative standard deviation", "none below zero")
        return Feedforward(
            axes=self.axes,
            basis=self.basis.basis(),
            weights=_matrix("weights", self.weights, shape),
            standard_deviations=deviations,
            kind=self.kind,
            parameters={name: quantity.value for name, quantity in self.parameters.items()},
            provenance=self.provenance,
        )


class LapMessage(Message):
    """One steady lap: phase [rad] and feedback [m/s^2], k rows."""

    phase: Annotated[list[Finite], Field(min_length=10, max_length=200_000)]
    feedback: list[list[Finite]]


class ContextMessage(Message):
    """Circumstances of a recording."""

    formulation: Annotated[str, Field(max_length=100)]
    model: Annotated[str, Field(max_length=100)]
    gains: dict[str, list[Finite]]
    version: Annotated[str, Field(max_length=100)]


class RecordMessage(Message):
    """The steady laps of one repetition.

    Attributes:
        task: Name of the motion.
        axes: Learned axes, names 'task.axis'.
        parameters: Task parameters, SI units.
        basis: Basis of the applied weights.
        applied: Weights in use during the repetition, k rows of L [m/s^2].
        laps: Whole steady laps.
        errors: Measures; rms_error_m is needed.
        context: Circumstances.
        rule: 'guarded' or 'plain'.
        update: False to note the errors only.
        restart: Forget the entry first.
    """

    task: Name
    axes: Annotated[tuple[Name, ...], Field(min_length=1, max_length=50)]
    parameters: dict[Name, Finite]
    basis: BasisMessage
    applied: list[list[Finite]]
    laps: Annotated[list[LapMessage], Field(min_length=1, max_length=100)]
    errors: dict[Name, Finite]
    context: ContextMessage
    rule: Literal["guarded", "plain"] = "guarded"
    update: bool = True
    restart: bool = False

    @classmethod
    def of(cls, recording: Recording) -> RecordMessage:
        """Describe a recording."""
        return cls(
            task=recording.key.task,
            axes=recording.key.axes,
            parameters=dict(recording.key.parameters),
            basis=BasisMessage.of(recording.basis),
            applied=recording.applied.tolist(),
            laps=[
                LapMessage(phase=lap.phase.tolist(), feedback=lap.feedback.tolist())
                for lap in recording.laps
            ],
            errors=recording.errors,
            context=ContextMessage(**vars(recording.context)),
            rule=recording.rule,
            update=recording.update,
            restart=recording.restart,
        )

    def recording(self, robot: str) -> Recording:
        """The recording.

        Args:
            robot: Name of the robot, from the key.

        Raises:
            MalformedMessage: If shapes do not fit or the RMS error is missing.
        """
        if "rms_error_m" not in self.errors or self.errors["rms_error_m"] < 0:
            raise MalformedMessage("errors without a valid rms_error_m", "an RMS error in metres")
        k = len(self.axes)
        return Recording(
            key=TaskKey.of(robot, self.task, self.axes, self.parameters),
            basis=self.basis.basis(),
            applied=_matrix("applied", self.applied, (k, self.basis.L)),
            laps=[
                Lap(
                    np.array(lap.phase),
                    _matrix(f"laps.{index}.feedback", lap.feedback, (k, len(lap.phase))),
                )
                for index, lap in enumerate(self.laps)
            ],
            errors=dict(self.errors),
            context=Context(**self.context.model_dump()),
            rule=self.rule,
            update=self.update,
            restart=self.restart,
        )


class EntryMessage(Message):
    """A database entry without its weights.

    Attributes:
        entry: Number of the entry.
        robot: Name of the robot.
        task: Name of the motion.
        axes: Learned axes.
        parameters: Task parameters with units.
        served: Iteration that a query is answered with.
        learning_gain: Share of the feedback that is added next.
        rule: 'guarded' or 'plain'.
        updated: ISO 8601, UTC.
        iterations: (number, errors or null) of every iteration.
    """

    entry: int
    robot: str
    task: str
    axes: tuple[str, ...]
    parameters: dict[str, QuantityMessage]
    served: int
    learning_gain: float
    rule: Literal["guarded", "plain"]
    updated: str
    iterations: list[tuple[int, dict[str, float] | None]]

    @classmethod
    def of(cls, entry: Entry) -> EntryMessage:
        """Describe an entry."""
        return cls(
            entry=entry.identifier,
            robot=entry.key.robot,
            task=entry.key.task,
            axes=entry.key.axes,
            parameters={
                name: QuantityMessage(value=value, unit=UNITS.get(name, ""))
                for name, value in entry.key.parameters
            },
            served=entry.served.number,
            learning_gain=entry.learning_gain,
            rule=entry.rule,
            updated=entry.updated,
            iterations=[(item.number, item.errors) for item in entry.iterations],
        )


class RecordReply(Message):
    """What came of a recording.

    Attributes:
        entry: The entry as it is now.
        notes: Remarks for the user.
    """

    entry: EntryMessage
    notes: list[str]


class DatabaseReply(Message):
    """What is known.

    Attributes:
        database: Path of the file, on the service's machine.
        entries: The entries.
        forgotten: The entry that was asked to be forgotten, if any.
    """

    database: str
    entries: list[EntryMessage]
    forgotten: EntryMessage | None = None


def _matrix(name: str, rows: list[list[float]], shape: tuple[int, int]) -> Any:
    if len(rows) != shape[0] or any(len(row) != shape[1] for row in rows):
        raise MalformedMessage(f"{name} of another shape", f"{shape[0]} rows of {shape[1]} numbers")
    return np.array(rows, dtype=float)


def json_schema() -> str:
    """JSON schema of the feedforward message, for the docs."""
    return json.dumps(FeedforwardMessage.model_json_schema(), indent=2)
