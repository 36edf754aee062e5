"""What happens in a run, for whoever watches it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter, ValidationError

from tsd_casadi.document import Finite
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.wire.axis import AxisErrorMessage, NotNegative
from tsd_casadi.wire.basis import BasisMessage
from tsd_casadi.wire.message import Message
from tsd_casadi.wire.run_outline import RunOutline
from tsd_casadi.wire.run_story import STORY

Count = Annotated[int, Field(ge=0)]
Weights = list[list[Finite]]


class RunEvent(Message):
    """What all events have in common.

    Attributes:
        format: Name and version of this message.
        number: Counts the events of a run from 1 on; one that is missing was dropped,
            and stands in the story.
        repetition: In which repetition, from 1 on; 0 before the first.
    """

    format: Literal["tsd.run-event/1"] = "tsd.run-event/1"
    number: Annotated[int, Field(ge=1)]
    repetition: Count


class RepetitionBegan(RunEvent):
    """A repetition is about to begin.

    Attributes:
        event: Which kind of event this is.
        outline: By which its rows are read.
        settings: How it is made, as far as who runs it says: model error, hardware,
            transport, pace, seed.
    """

    event: Literal["began"] = "began"
    outline: RunOutline
    settings: dict[str, Any] = Field(default_factory=dict)


class LapDone(RunEvent):
    """A whole lap is over.

    Attributes:
        event: Which kind of event this is.
        lap: How many there were, with this one.
        rms: RMS error by learned axis, as the controller sees it [m, rad].
        ac_rms: The same without its mean [m, rad].
        mean_abs_feedback: Mean absolute feedback [m/s^2, rad/s^2].
    """

    event: Literal["lap"] = "lap"
    lap: Annotated[int, Field(ge=1)]
    rms: dict[str, NotNegative]
    ac_rms: dict[str, NotNegative]
    mean_abs_feedback: dict[str, NotNegative]


class RepetitionEnded(RunEvent):
    """A repetition is over.

    Attributes:
        event: Which kind of event this is.
        outcome: How it ended.
    """

    event: Literal["ended"] = "ended"
    outcome: Literal["steady", "never steady", "fell", "aborted"]


class RepetitionMeasured(RunEvent):
    """What a repetition was like, over its steady laps.

    Attributes:
        event: Which kind of event this is.
        summary: As ``tsd simulate --json`` writes it: errors by axis, rank, vetoes,
            remarks.
        notes: What else people should know of it; those of the learner, too.
    """

    event: Literal["measured"] = "measured"
    summary: dict[str, Any]
    notes: list[str] = Field(default_factory=list)


class IterationRecorded(RunEvent):
    """A repetition was recorded, and something learned from it or not.

    Attributes:
        event: Which kind of event this is.
        entry: Number of the entry in the database.
        motion: Name of the motion.
        parameters: Of the motion, by name.
        axes: Learned axes, k of them.
        iteration: Number of the one that was tested; 0 for no feedforward.
        learned_from: Number of the one that it was learned from, if known.
        epoch: Counts how often the robot had changed before.
        errors: By axis, with their repeatability: ``deviation`` is that of the RMS error
            of a single lap.
        rank: By which iterations are ranked [m/s^2, rad/s^2].
        basis: Of the weights.
        before: Weights that were in use, k rows of L numbers [unit/s^2].
        after: Weights that a query is answered with from now on; null if none is.
        served: Number of their iteration.
        learning_gain: Share of the feedback that is added next.
        rule: Of the learning.
        contractions: What iterations leave of an error, by learned axis and harmonic.
        notes: Remarks of the learner.
    """

    event: Literal["iteration"] = "iteration"
    entry: int
    motion: str
    parameters: dict[str, Finite]
    axes: tuple[str, ...]
    iteration: Count
    learned_from: int | None = None
    epoch: Count = 0
    errors: dict[str, AxisErrorMessage]
    rank: NotNegative | None = None
    basis: BasisMessage
    before: Weights
    after: Weights | None = None
    served: Count
    learning_gain: float
    rule: str
    contractions: tuple[Contraction, ...] = ()
    notes: list[str] = Field(default_factory=list)


class RunOver(RunEvent):
    """The run is over: nothing comes any more.

    Attributes:
        event: Which kind of event this is.
        reason: What ended it early; empty for nothing.
    """

    event: Literal["over"] = "over"
    reason: str = ""


AnyEvent = (
    RepetitionBegan | LapDone | RepetitionEnded | RepetitionMeasured | IterationRecorded | RunOver
)
KINDS: tuple[type[RunEvent], ...] = (
    RepetitionBegan,
    LapDone,
    RepetitionEnded,
    RepetitionMeasured,
    IterationRecorded,
    RunOver,
)
_EVENTS: TypeAdapter[AnyEvent] = TypeAdapter(Annotated[AnyEvent, Field(discriminator="event")])


def decode_event(payload: bytes) -> AnyEvent:
    """Read and check an event.

    Raises:
        MalformedMessage: If it is none.
    """
    try:
        return _EVENTS.validate_json(payload)
    except ValidationError as error:
        raise MalformedMessage(f"an event: {error.errors()[0]['msg']}", "one of a run") from error


class RunStory(Message):
    """What has happened in a run so far, for who comes late or missed an event.

    Attributes:
        format: Name and version of this message.
        events: In order: every iteration that was recorded, and the newest of all other
            kinds.
    """

    format: Literal["tsd.run-story/1"] = STORY
    events: list[Annotated[AnyEvent, Field(discriminator="event")]]
