"""How a service is: what it answered, refused and failed at, and how fast."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from tsd_casadi.document import Document
from tsd_casadi.wire.latency import Count, LatencyMessage
from tsd_casadi.wire.message import Instance, Message


class AnswersMessage(Document):
    """What became of the queries on one key.

    Attributes:
        answered: With what was asked for.
        refused: With an error, by its code.
        failed: Because of a defect of the service, by the kind of exception.
        waiting: Taken up and not answered yet. At most 64 more may wait unseen, and
            of those that come then the oldest are dropped.
        latency: From the moment that a query is taken up to its answer.
    """

    answered: Count = 0
    refused: dict[str, Count] = Field(default_factory=dict)
    failed: dict[str, Count] = Field(default_factory=dict)
    waiting: Count = 0
    latency: LatencyMessage


class DatabaseStateMessage(Document):
    """How the database file of a learner is.

    Attributes:
        path: The file, on the service's machine.
        schema_version: Of its tables.
        entries: Number of entries.
        damaged: Number of entries that could not be read since it was opened.
        size: Of the file and of what is not yet merged into it [bytes].
        last_write: When something was added last, ISO 8601, UTC.
    """

    path: str
    schema_version: Count
    entries: Count
    damaged: Count
    size: Count
    last_write: str | None = None


class HealthMessage(Message):
    """How a service is.

    Attributes:
        format: Name and version of this message.
        role: 'controller' or 'learner'.
        robot: Name of the robot; ``*`` for a learner.
        instance: Id of the service, as in every reply.
        pid: Number of its process, on its machine.
        started: When its session was opened; ISO 8601, UTC.
        uptime: Since then [s].
        versions: Of the software, of Zenoh, of the JSON messages and of the tick.
        answers: By the last word of the key.
        ticks: Ticks answered, by the name of their status; of a controller.
        database: State of the database; of a learner.
    """

    format: Literal["tsd.health/2"] = "tsd.health/2"
    role: str
    robot: str
    instance: Instance
    pid: Annotated[int, Field(gt=0)]
    started: str
    uptime: Annotated[float, Field(ge=0)]
    versions: dict[str, str]
    answers: dict[str, AnswersMessage]
    ticks: dict[str, Count] | None = None
    database: DatabaseStateMessage | None = None
