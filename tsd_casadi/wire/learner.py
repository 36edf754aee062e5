"""What is recorded with a learner, and what it knows."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from tsd_casadi.document import Document, Finite, Name, to_matrix
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import USUAL, Instruction
from tsd_casadi.learning.recording import Context, Recording
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.wire.feedforward import BasisMessage, QuantityMessage


class LapMessage(Document):
    """One steady lap.

    Attributes:
        phase: [rad].
        feedback: Feedback term along the learned axes, k rows [m/s^2].
        error: Position error x_ref - x there, k rows [m]; the rule 'stable'
            needs it.
        reference: x_ref, k rows [m], together with the error.
    """

    phase: Annotated[list[Finite], Field(min_length=10, max_length=200_000)]
    feedback: list[list[Finite]]
    error: list[list[Finite]] | None = None
    reference: list[list[Finite]] | None = None

    @classmethod
    def of(cls, lap: Lap) -> LapMessage:
        """Describe a lap."""
        return cls(
            phase=lap.phase.tolist(),
            feedback=lap.feedback.tolist(),
            error=None if lap.error is None else lap.error.tolist(),
            reference=None if lap.reference is None else lap.reference.tolist(),
        )

    def lap(self, k: int) -> Lap:
        """Make the lap.

        Args:
            k: Number of learned axes.

        Raises:
            MalformedMessage: If shapes do not fit.
        """
        shape = k, len(self.phase)
        if (self.error is None) != (self.reference is None):
            raise MalformedMessage(
                "a lap with only one of error and reference", "both of them, or neither"
            )
        return Lap(
            phase=np.array(self.phase),
            feedback=to_matrix("feedback of a lap", self.feedback, shape),
            error=None if self.error is None else to_matrix("error of a lap", self.error, shape),
            reference=None
            if self.reference is None
            else to_matrix("reference of a lap", self.reference, shape),
        )


class ContextMessage(Document):
    """Circumstances of a recording."""

    formulation: Annotated[str, Field(max_length=100)]
    model: Annotated[str, Field(max_length=100)]
    gains: dict[str, list[Finite]]
    version: Annotated[str, Field(max_length=100)]


class RecordMessage(Document):
    """The steady laps of one repetition, and what to do with them.

    Attributes:
        task: Name of the motion.
        axes: Learned axes, names 'task.axis'.
        parameters: Of the motion, SI units; those with a default may be left out.
        basis: Basis of the applied weights.
        applied: Weights in use during the repetition, k rows of L [m/s^2].
        laps: Whole steady laps.
        errors: Measures; rms_error_m is needed.
        context: Circumstances.
        rule: Of the learning, see the schema.
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
    rule: RuleName = "guarded"
    update: bool = True
    restart: bool = False

    @classmethod
    def of(cls, recording: Recording, instruction: Instruction = USUAL) -> RecordMessage:
        """Describe a recording and what to do with it."""
        return cls(
            task=recording.key.motion,
            axes=recording.key.axes,
            parameters=dict(recording.key.parameters),
            basis=BasisMessage.of(recording.basis),
            applied=recording.applied.tolist(),
            laps=[LapMessage.of(lap) for lap in recording.laps],
            errors=recording.errors,
            context=ContextMessage(**vars(recording.context)),
            rule=instruction.rule.name,
            update=instruction.update,
            restart=instruction.restart,
        )

    def recording(self, robot: str) -> Recording:
        """Make the recording.

        Args:
            robot: Name of the robot, from the key.

        Raises:
            MalformedMessage: If shapes do not fit or the RMS error is missing.
        """
        if "rms_error_m" not in self.errors or self.errors["rms_error_m"] < 0:
            raise MalformedMessage("errors without a valid rms_error_m", "an RMS error in metres")
        k = len(self.axes)
        return Recording(
            key=EntryKey.of(robot, self.task, self.axes, self.parameters),
            basis=self.basis.basis(),
            applied=to_matrix("applied", self.applied, (k, self.basis.L)),
            laps=[lap.lap(k) for lap in self.laps],
            errors=dict(self.errors),
            context=Context(**self.context.model_dump()),
        )

    def instruction(self) -> Instruction:
        """Make the order that came with the recording."""
        return Instruction(find_rule(self.rule), self.update, self.restart)


class EntryMessage(Document):
    """A database entry without its weights.

    Attributes:
        entry: Number of the entry.
        robot: Name of the robot.
        task: Name of the motion.
        axes: Learned axes.
        parameters: Of the motion, with units.
        served: Iteration that a query is answered with.
        learning_gain: Share of the feedback that is added next.
        rule: Of the learning, see the schema.
        updated: ISO 8601, UTC.
        iterations: (number, errors or null) of every iteration.
        contractions: What iterations leave of an error, by learned axis and
            harmonic; none while position errors are unknown.
    """

    entry: int
    robot: str
    task: str
    axes: tuple[str, ...]
    parameters: dict[str, QuantityMessage]
    served: int
    learning_gain: float
    rule: RuleName
    updated: str
    iterations: list[tuple[int, dict[str, float] | None]]
    contractions: tuple[Contraction, ...] = ()

    @classmethod
    def of(cls, entry: Entry) -> EntryMessage:
        """Describe an entry."""
        return cls(
            entry=entry.identifier,
            robot=entry.key.robot,
            task=entry.key.motion,
            axes=entry.key.axes,
            parameters={
                name: QuantityMessage.of(entry.key.motion, name, value)
                for name, value in entry.key.parameters
            },
            served=entry.served.number,
            learning_gain=entry.learning_gain,
            rule=entry.rule.name,
            updated=entry.updated,
            iterations=[(item.number, item.errors) for item in entry.iterations],
            contractions=entry.contractions,
        )


class RecordReply(Document):
    """What came of a recording.

    Attributes:
        entry: The entry as it is now.
        notes: Remarks for the user.
    """

    entry: EntryMessage
    notes: list[str]


class DatabaseReply(Document):
    """What is known.

    Attributes:
        database: Path of the file, on the service's machine.
        entries: The entries.
        forgotten: The entry that was asked to be forgotten, if any.
    """

    database: str
    entries: list[EntryMessage]
    forgotten: EntryMessage | None = None
