"""The learner service: keeps what was learned, answers what to feed forward."""

from __future__ import annotations

import importlib
import math
from collections.abc import Sequence
from pathlib import Path

import zenoh

from tsd_casadi.database import Database
from tsd_casadi.exceptions import InvalidValue, MalformedMessage
from tsd_casadi.keys import ANY_ROBOT, database_key, feedforward_key, record_key, robot_of
from tsd_casadi.messages import (
    DatabaseReply,
    EntryMessage,
    FeedforwardMessage,
    RecordMessage,
    RecordReply,
)
from tsd_casadi.motions.squat import UNITS
from tsd_server.service import Service, reply_json

# robot chunk of replies to a query for any robot
EVERY = "all"
# some ten times the laps of the slowest squat [bytes]
LARGEST_RECORDING = 20_000_000
OPTIONS = ("task", "kind", "extrapolate")


class LearnerService:
    """Answers record, feedforward and database queries for every robot.

    Attributes:
        path: The database file.
    """

    def __init__(self, path: Path, listen: Sequence[str]) -> None:
        """Open session and database.

        Args:
            path: The database file, made if there is none.
            listen: Endpoints to listen on.

        Raises:
            DatabaseError: If the file is not one of ours.
            EndpointTaken: If it cannot listen there.
        """
        self.path = path
        Database(path).close()  # refuse a wrong file before listening
        # the first regression would wait seconds for it
        importlib.import_module("sklearn.gaussian_process")
        self._service = Service("learner", ANY_ROBOT, listen)
        self._database: Database | None = None

    def run(self) -> None:
        """Serve until SIGINT or SIGTERM."""
        with self._service as service:
            # one key for all three, so that one thread owns the database
            service.answer("tsd/*/learner/*", self._answer)
            service.run(f"database {self.path}")

    @property
    def _open_database(self) -> Database:
        # SQLite wants to be used by the thread that opened it
        if self._database is None:
            self._database = Database(self.path)
        return self._database

    def _answer(self, query: zenoh.Query) -> None:
        key = str(query.key_expr)
        robot = robot_of(key)
        answers = {
            feedforward_key(robot): self._feedforward,
            record_key(robot): self._record,
            database_key(robot): self._entries,
        }
        if key not in answers:
            raise MalformedMessage(f"key {key}", f"one of {', '.join(answers)}")
        answers[key](query, robot)

    def _feedforward(self, query: zenoh.Query, robot: str) -> None:
        if robot == ANY_ROBOT:
            raise MalformedMessage("a feedforward for any robot", "the robot's name in the key")
        texts = {name: str(value) for name, value in _items(query.parameters)}
        if "task" not in texts:
            raise MalformedMessage(
                "no task in the query", "?task=squat;amplitude=0.05;frequency=0.25"
            )
        kind = texts.get("kind")
        if kind not in (None, "learned", "generalised"):
            raise InvalidValue("kind", repr(kind), "learned or generalised")
        extrapolate = texts.get("extrapolate", "false").lower()
        if extrapolate not in ("true", "false"):
            raise InvalidValue("extrapolate", repr(extrapolate), "true or false")
        parameters = _parameters({n: t for n, t in texts.items() if n not in OPTIONS})
        feedforward = self._open_database.query(
            texts["task"],
            robot=robot,
            kind=kind,
            extrapolate=extrapolate == "true",
            **parameters,
        )
        message = FeedforwardMessage.of(robot, texts["task"], feedforward)
        reply_json(query, feedforward_key(robot), message.encode())

    def _record(self, query: zenoh.Query, robot: str) -> None:
        if robot == ANY_ROBOT:
            raise MalformedMessage("a recording for any robot", "the robot's name in the key")
        if query.payload is None:
            raise MalformedMessage("no payload", "a recording as JSON; see docs/wire.md")
        payload = query.payload.to_bytes()
        if len(payload) > LARGEST_RECORDING:
            raise MalformedMessage(
                f"a recording of {len(payload)} bytes", f"at most {LARGEST_RECORDING}"
            )
        recording = RecordMessage.decode(payload).recording(robot)
        _parameters({name: str(value) for name, value in recording.key.parameters})
        entry, notes = self._open_database.record(recording)
        reply = RecordReply(entry=EntryMessage.of(entry), notes=notes)
        reply_json(query, record_key(robot), reply.encode())

    def _entries(self, query: zenoh.Query, robot: str) -> None:
        forgotten = None
        forget = query.parameters.get("forget")
        if forget is not None:
            if not str(forget).isdigit():
                raise InvalidValue("forget", repr(str(forget)), "the number of an entry")
            forgotten = EntryMessage.of(self._open_database.forget(int(forget)))
        entries = self._open_database.entries(None if robot == ANY_ROBOT else robot)
        reply = DatabaseReply(
            database=str(self.path),
            entries=[EntryMessage.of(entry) for entry in entries],
            forgotten=forgotten,
        )
        name = EVERY if robot == ANY_ROBOT else robot
        reply_json(query, database_key(name), reply.encode())


def _items(parameters: zenoh.Parameters) -> list[tuple[str, str]]:
    # the stub does not know that Parameters iterate over pairs
    return list(dict(parameters).items())  # type: ignore[call-overload]


def _parameters(texts: dict[str, str]) -> dict[str, float]:
    """Task parameters from a selector, every one known, present and positive."""
    parameters = {}
    for name, text in texts.items():
        if name not in UNITS:
            raise InvalidValue(
                f"parameter '{name}'", repr(text), f"only {', '.join((*OPTIONS, *UNITS))}"
            )
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not 0 < value < 1e6:
            raise InvalidValue(name, repr(text), f"a positive number in {UNITS[name]}")
        parameters[name] = value
    missing = [name for name in UNITS if name not in parameters]
    if missing:
        raise MalformedMessage(
            f"no {' and no '.join(missing)} in the query",
            "?task=squat;amplitude=0.05;frequency=0.25",
        )
    return parameters
