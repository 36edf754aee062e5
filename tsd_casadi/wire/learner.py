"""What a learner knows, and what came of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field

from tsd_casadi.document import Document
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.wire.axis import AxisErrorMessage, AxisMessage, axis_messages, error_messages
from tsd_casadi.wire.context import CircumstancesMessage, ContextMessage
from tsd_casadi.wire.declaration import QuantityMessage, quantities
from tsd_casadi.wire.message import Instance, Message


class IterationMessage(Document):
    """An iteration without its weights.

    Attributes:
        number: 0 for no feedforward, then counting up.
        errors: By axis; null while untested.
        circumstances: How that repetition was made; null while untested.
        learned_from: Number of the iteration that it was learned from, if known.
        epoch: Counts how often the robot had changed before.
    """

    number: int
    errors: dict[str, AxisErrorMessage] | None = None
    circumstances: CircumstancesMessage | None = None
    learned_from: int | None = None
    epoch: int = 0

    @classmethod
    def of(cls, iteration: Iteration) -> IterationMessage:
        """Describe an iteration."""
        errors, circumstances = iteration.errors, iteration.circumstances
        return cls(
            number=iteration.number,
            errors=None if errors is None else error_messages(errors),
            circumstances=None if circumstances is None else CircumstancesMessage.of(circumstances),
            learned_from=iteration.learned_from,
            epoch=iteration.epoch,
        )


class EntryMessage(Document):
    """A database entry without its weights.

    Attributes:
        entry: Number of the entry.
        robot: Name of the robot.
        motion: Name of the motion.
        version: Of the motion.
        axes: Learned axes.
        parameters: Of the motion, with units.
        context: What it belongs to; empty where nobody knows.
        served: Iteration that a query is answered with.
        learning_gain: Share of the feedback that is added next.
        rule: Of the learning, see the schema.
        updated: ISO 8601, UTC.
        iterations: Every iteration.
        contractions: What iterations leave of an error, by learned axis and
            harmonic; none while position errors are unknown, nor in lists, for
            which no weights are decoded.
    """

    entry: int
    robot: str
    motion: str
    version: str
    axes: list[AxisMessage]
    parameters: dict[str, QuantityMessage]
    context: ContextMessage
    served: int
    learning_gain: float
    rule: RuleName
    updated: str
    iterations: list[IterationMessage]
    contractions: tuple[Contraction, ...] = ()

    @classmethod
    def of(cls, entry: Entry) -> EntryMessage:
        """Describe an entry."""
        key = entry.key
        declaration = entry.declaration or Declaration.unknown(key.motion, key.version)
        return cls(
            entry=entry.identifier,
            robot=key.robot,
            motion=key.motion,
            version=key.version,
            axes=axis_messages(key.axes),
            parameters=quantities(declaration, dict(key.parameters)),
            context=ContextMessage.of(key.context),
            served=entry.served.number,
            learning_gain=entry.learning_gain,
            rule=entry.rule.name,
            updated=entry.updated,
            iterations=[IterationMessage.of(item) for item in entry.iterations],
            contractions=entry.contractions,
        )


class DamagedMessage(Document):
    """An entry that cannot be read any more.

    Attributes:
        entry: Number of the entry.
        reason: What is wrong with it.
    """

    entry: int
    reason: str


class RecordReply(Message):
    """What came of a recording.

    Attributes:
        format: Name and version of this message.
        instance: Id of the service.
        entry: The entry as it is now.
        notes: Remarks for the user.
    """

    format: Literal["tsd.recorded/2"] = "tsd.recorded/2"
    instance: Instance = 0
    entry: EntryMessage
    notes: list[str]


class DatabaseReply(Message):
    """What is known.

    Attributes:
        format: Name and version of this message.
        instance: Id of the service.
        database: Path of the file, on the service's machine.
        entries: Those of the page that was asked for, in the order of their numbers.
        damaged: Entries of the page that cannot be read.
        more: Number of entries that were asked for, beyond the page.
        forgotten: The entry that was asked to be forgotten, if any, and if it
            could be read.
    """

    format: Literal["tsd.database/2"] = "tsd.database/2"
    instance: Instance = 0
    database: str
    entries: list[EntryMessage]
    damaged: tuple[DamagedMessage, ...] = ()
    more: Annotated[int, Field(ge=0)] = 0
    forgotten: EntryMessage | None = None


def entry_messages(entries: Sequence[Entry]) -> list[EntryMessage]:
    """Describe entries."""
    return [EntryMessage.of(entry) for entry in entries]
