"""The learner service: keeps what was learned, answers what to feed forward."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

import zenoh

from tsd_casadi.database.database import Database
from tsd_casadi.database.kept_entries import KeptEntries
from tsd_casadi.database.reading import Reading
from tsd_casadi.exceptions import EntryNotFound, InvalidValue, MalformedMessage
from tsd_casadi.learning.entry import Entry
from tsd_casadi.wire.feedforward import FeedforwardMessage
from tsd_casadi.wire.health import DatabaseStateMessage
from tsd_casadi.wire.keys import (
    ANY_ROBOT,
    database_key,
    feedforward_key,
    health_key,
    record_key,
    robot_of,
    suggestion_key,
)
from tsd_casadi.wire.learner import (
    DamagedMessage,
    DatabaseReply,
    EntryMessage,
    RecordReply,
    entry_messages,
)
from tsd_casadi.wire.question import Question, number
from tsd_casadi.wire.record import RecordMessage
from tsd_casadi.wire.suggestion import SuggestionMessage
from tsd_server.kept_replies import KeptReplies
from tsd_server.place import Place
from tsd_server.service import Service, reply_json
from tsd_server.waiting_line import Later

# last words of the keys
ANSWERS = ("feedforward", "suggestion", "record", "database", "health")
# robot chunk of replies to a query for any robot
EVERY = "all"
# some ten times the laps of the slowest squat [bytes]
LARGEST_RECORDING = 50_000_000
# the number of an entry, as large as SQLite's may be
_ENTRY = re.compile(r"[0-9]{1,18}", re.ASCII)
QUERY = "?motion=squat;amplitude=0.05;frequency=0.25"
REGION = "?motion=squat;amplitude=0.02:0.08;frequency=0.2:0.6"


class LearnerService:
    """Answers feedforward, suggestion, record and database queries for every robot.

    Attributes:
        path: The database file.
    """

    def __init__(self, path: Path, place: Place) -> None:
        """Open session and database.

        Args:
            path: The database file, made if there is none.
            place: Where to listen.

        Raises:
            AlreadyRunning: If the file has a learner.
            DatabaseError: If the file is not one of ours.
            EndpointTaken: If it cannot listen there.
        """
        self.path = path
        kept = KeptEntries()
        # a connection for each thread; a wrong file is refused before listening
        self._database = Database(path, kept)
        self._exact, self._listing, self._fitting = (Reading(path, kept) for _ in range(3))
        self._kept_replies = KeptReplies()
        # the first regression would wait seconds for it
        importlib.import_module("scipy.optimize")
        importlib.import_module("scipy.stats")
        self._service = Service("learner", ANY_ROBOT, place, subject=str(path.resolve()))

    def run(self) -> None:
        """Serve until SIGINT or SIGTERM."""
        with self._service as service:
            # what takes its time waits beside what is looked up in an instant
            self._writes, self._lists, self._fits = (service.line() for _ in range(3))
            service.answer("tsd/*/learner/*", self._answer, ANSWERS)
            service.run(f"database {self.path}")
        for opened in (self._exact, self._listing, self._fitting, self._database):
            opened.close()

    def _answer(self, query: zenoh.Query) -> Later | None:
        key = str(query.key_expr)
        robot = robot_of(key)
        answers: dict[str, Callable[[zenoh.Query, str], Later | None]] = {
            feedforward_key(robot): self._feedforward,
            suggestion_key(robot): self._suggestion,
            record_key(robot): self._record,
            database_key(robot): self._entries,
            health_key(robot, "learner"): self._health,
        }
        if key not in answers:
            raise MalformedMessage(f"key {key}", f"one of {', '.join(answers)}")
        return answers[key](query, robot)

    def _feedforward(self, query: zenoh.Query, robot: str) -> Later | None:
        if robot == ANY_ROBOT:
            raise MalformedMessage("a feedforward for any robot", "the robot's name in the key")
        texts = _texts(query)
        question = robot, *sorted(texts.items())  # in whatever order they come
        body = self._kept_replies.find(question, self._exact.version())
        if body is None:
            asked = Question.of(texts, QUERY)
            if asked.kind == "generalised":
                return self._generalize_later(robot, asked)
            try:
                body = self._ask(robot, replace(asked, kind="learned"), self._exact)
            except EntryNotFound:
                if asked.kind == "learned":
                    raise
                return self._generalize_later(robot, asked)
            self._kept_replies.keep(question, body, self._exact.version())
        reply_json(query, feedforward_key(robot), body)
        return None

    def _generalize_later(self, robot: str, asked: Question) -> Later:
        def answer(query: zenoh.Query) -> None:
            reply_json(query, feedforward_key(robot), self._ask(robot, asked, self._fitting))

        return Later(self._fits, answer)

    def _ask(self, robot: str, asked: Question, reading: Reading) -> bytes:
        feedforward = reading.query(
            asked.motion,
            robot=robot,
            kind=asked.kind,
            extrapolate=asked.extrapolate,
            axes=asked.axes,
            context=asked.context,
            version=asked.version,
            **asked.numbers(),
        )
        message = FeedforwardMessage.of(robot, asked.motion, feedforward, self._service.instance)
        return message.encode()

    def _suggestion(self, query: zenoh.Query, robot: str) -> Later:
        return Later(self._fits, lambda query: self._suggest(query, robot))

    def _suggest(self, query: zenoh.Query, robot: str) -> None:
        if robot == ANY_ROBOT:
            raise MalformedMessage("a suggestion for any robot", "the robot's name in the key")
        asked = Question.of(_texts(query), REGION)
        if asked.kind is not None or asked.extrapolate:
            raise InvalidValue("the query", "with kind or extrapolate", f"neither, as in {REGION}")
        region, fixed = {}, {}
        for name, text in asked.parameters.items():
            low, colon, high = text.partition(":")
            if colon:
                region[name] = number(name, low), number(name, high)
            else:
                fixed[name] = number(name, text)
        suggestion = self._fitting.suggest(
            asked.motion,
            robot=robot,
            region=region,
            axes=asked.axes,
            context=asked.context,
            version=asked.version,
            **fixed,
        )
        message = SuggestionMessage.of(robot, asked.motion, suggestion, self._service.instance)
        reply_json(query, suggestion_key(robot), message.encode())

    def _record(self, query: zenoh.Query, robot: str) -> Later:
        return Later(self._writes, lambda query: self._take_in(query, robot))

    def _take_in(self, query: zenoh.Query, robot: str) -> None:
        if robot == ANY_ROBOT:
            raise MalformedMessage("a recording for any robot", "the robot's name in the key")
        if query.payload is None:
            raise MalformedMessage("no payload", "a recording as JSON; see docs/wire.md")
        payload = query.payload.to_bytes()
        if len(payload) > LARGEST_RECORDING:
            raise MalformedMessage(
                f"a recording of {len(payload)} bytes", f"at most {LARGEST_RECORDING}"
            )
        message = RecordMessage.decode(payload)
        recording = message.recording(robot)
        entry, notes = self._database.record(recording, message.instruction())
        reply = RecordReply(
            instance=self._service.instance, entry=EntryMessage.of(entry), notes=notes
        )
        reply_json(query, record_key(robot), reply.encode())

    def _entries(self, query: zenoh.Query, robot: str) -> Later:
        if query.parameters.get("forget") is None:
            return Later(self._lists, lambda query: self._list(query, robot, self._listing))
        return Later(self._writes, lambda query: self._forget(query, robot))

    def _forget(self, query: zenoh.Query, robot: str) -> None:
        forget = str(query.parameters.get("forget"))
        if _ENTRY.fullmatch(forget) is None:
            raise InvalidValue("forget", repr(forget), "the number of an entry")
        forgotten = self._database.forget(int(forget))
        self._list(query, robot, self._database, forgotten)

    def _list(
        self, query: zenoh.Query, robot: str, reading: Reading, forgotten: Entry | None = None
    ) -> None:
        entries, damaged = reading.outlines(None if robot == ANY_ROBOT else robot)
        reply = DatabaseReply(
            instance=self._service.instance,
            database=str(self.path),
            entries=entry_messages(entries),
            damaged=tuple(
                DamagedMessage(entry=each.identifier, reason=each.reason) for each in damaged
            ),
            forgotten=None if forgotten is None else EntryMessage.of(forgotten),
        )
        name = EVERY if robot == ANY_ROBOT else robot
        reply_json(query, database_key(name), reply.encode())

    def _health(self, query: zenoh.Query, robot: str) -> None:
        name = EVERY if robot == ANY_ROBOT else robot
        state = DatabaseStateMessage(**asdict(self._exact.state()))
        reply_json(
            query, health_key(name, "learner"), self._service.health(database=state).encode()
        )


def _texts(query: zenoh.Query) -> dict[str, str]:
    """Read the selector's parameters."""
    # the stub does not know that Parameters iterate over pairs
    pairs = list(dict(query.parameters).items())  # type: ignore[call-overload]
    return {str(name): str(value) for name, value in pairs}
