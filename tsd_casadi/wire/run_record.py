"""What a service or a run says of itself in the run directory."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from tsd_casadi.document import Document
from tsd_casadi.exceptions import MalformedMessage

# a record is some hundred bytes; more is none of ours [bytes]
LARGEST = 100_000


class RunRecord(Document):
    """What runs, in a file of the run directory.

    Attributes:
        format: Name and version of this document.
        role: 'controller', 'learner', or what else can be watched.
        subject: What it serves, once on this machine: the robot or the database file.
        robot: Name of the robot; ``*`` for a learner.
        pid: Number of the process.
        endpoints: Where it listens.
        instance: Id of the service, as in its replies.
        started: ISO 8601, UTC.
        telemetry: Where it can be watched, if it can.
        motion: What is done, in a run.
    """

    format: Literal["tsd.run/1"] = "tsd.run/1"
    role: str
    subject: str
    robot: str
    pid: Annotated[int, Field(gt=0)]
    endpoints: tuple[str, ...]
    instance: Annotated[int, Field(ge=0)]
    started: str
    telemetry: str | None = None
    motion: str | None = None

    @classmethod
    def of_this_process(
        cls,
        role: str,
        subject: str,
        *,
        robot: str,
        endpoints: tuple[str, ...],
        instance: int,
        motion: str | None = None,
    ) -> RunRecord:
        """Describe a service that this process is about to be, or a run with its motion."""
        return cls(
            role=role,
            subject=subject,
            robot=robot,
            pid=os.getpid(),
            endpoints=endpoints,
            instance=instance,
            started=datetime.now(UTC).isoformat(timespec="seconds"),
            telemetry=None if motion is None else endpoints[0],
            motion=motion,
        )


@contextmanager
def opened(path: Path) -> Iterator[int | None]:
    """Open a file of the run directory for a moment; None if it is gone, or none of ours."""
    try:
        file = os.open(path, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW)
    except OSError:  # gone meanwhile, or none of ours
        yield None
        return
    try:
        yield file
    finally:
        os.close(file)


def read_record(file: int) -> RunRecord | None:
    """Read a record; None while its owner is about to write it."""
    try:
        return RunRecord.decode(os.pread(file, LARGEST, 0))
    except MalformedMessage:
        return None


def is_at(file: int, path: Path) -> bool:
    """Whether the file that was opened is the one that stands there now."""
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except FileNotFoundError:
        return False
