"""The laps of one repetition, as they are recorded with a learner."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from tsd_casadi.document import Document, Finite, Name, to_matrix
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import USUAL, Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.wire.axis import (
    Axes,
    AxisErrorMessage,
    axis_messages,
    error_messages,
    plain_axes,
    plain_errors,
)
from tsd_casadi.wire.basis import BasisMessage
from tsd_casadi.wire.context import CircumstancesMessage, ContextMessage
from tsd_casadi.wire.declaration import DeclarationMessage
from tsd_casadi.wire.message import Message, VersionText


class LapMessage(Document):
    """One steady lap.

    Attributes:
        phase: [rad].
        feedback: Feedback term along the learned axes, k rows [unit/s^2].
        error: Position error x_ref - x there, k rows [unit]; the rule 'stable'
            needs it.
        reference: x_ref, k rows [unit], together with the error.
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


class RecordMessage(Message):
    """The steady laps of one repetition, and what to do with them.

    Attributes:
        format: Name and version of this message.
        motion: Name of the motion.
        version: Of the motion.
        axes: Learned axes, k of them.
        parameters: Of the motion, SI units; those with a default may be left out.
        basis: Basis of the applied weights.
        applied: Weights in use during the repetition, k rows of L [unit/s^2].
        laps: Whole steady laps.
        errors: Measures by axis.
        context: What the entry belongs to.
        circumstances: How the repetition was made.
        declaration: What is said of the motion: units, defaults and ranges of its
            parameters; those of the newest recording count if null.
        rule: Of the learning, see the schema.
        update: False to note the errors only.
        restart: Forget the entry first.
    """

    format: Literal["tsd.record/2"] = "tsd.record/2"
    motion: Name
    version: VersionText
    axes: Axes
    parameters: Annotated[dict[Name, Finite], Field(max_length=50)]
    basis: BasisMessage
    applied: list[list[Finite]]
    laps: Annotated[list[LapMessage], Field(min_length=1, max_length=100)]
    errors: dict[Name, AxisErrorMessage]
    context: ContextMessage
    circumstances: CircumstancesMessage
    declaration: DeclarationMessage | None = None
    rule: RuleName = "guarded"
    update: bool = True
    restart: bool = False

    @classmethod
    def of(cls, recording: Recording, instruction: Instruction = USUAL) -> RecordMessage:
        """Describe a recording and what to do with it."""
        key, declaration = recording.key, recording.declaration
        return cls(
            motion=key.motion,
            version=key.version,
            axes=axis_messages(key.axes),
            parameters=dict(key.parameters),
            basis=BasisMessage.of(recording.basis),
            applied=recording.applied.tolist(),
            laps=[LapMessage.of(lap) for lap in recording.laps],
            errors=error_messages(recording.errors),
            context=ContextMessage.of(key.context),
            circumstances=CircumstancesMessage.of(recording.circumstances),
            declaration=None if declaration is None else DeclarationMessage.of(declaration),
            rule=instruction.rule.name,
            update=instruction.update,
            restart=instruction.restart,
        )

    def recording(self, robot: str) -> Recording:
        """Make the recording.

        Args:
            robot: Name of the robot, from the key.

        Raises:
            MalformedMessage: If shapes or units do not fit.
        """
        axes = plain_axes(self.axes)
        return Recording(
            key=EntryKey.of(
                robot, self.motion, self.version, axes, self.parameters, self.context.context()
            ),
            basis=self.basis.basis(),
            applied=to_matrix("applied", self.applied, (len(axes), self.basis.L)),
            laps=[lap.lap(len(axes)) for lap in self.laps],
            errors=plain_errors(self.errors, axes),
            circumstances=self.circumstances.circumstances(),
            declaration=None if self.declaration is None else self.declaration.declaration(),
        )

    def instruction(self) -> Instruction:
        """Make the order that came with the recording."""
        return Instruction(find_rule(self.rule), self.update, self.restart)
