"""The learner service: keeps what was learned, answers what to feed forward."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import zenoh

from tsd_casadi.database.database import Database
from tsd_casadi.database.kept_entries import KeptEntries
from tsd_casadi.database.reading import Reading
from tsd_casadi.exceptions import MalformedMessage
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
from tsd_casadi.wire.listing import Listing
from tsd_casadi.wire.record import RecordMessage
from tsd_server.feedforward_answers import FeedforwardAnswers, texts
from tsd_server.place import Place
from tsd_server.service import Service, reply_json
from tsd_server.waiting_line import Later

# last words of the keys
ANSWERS = ("feedforward", "suggestion", "record", "database", "health")
# robot chunk of replies to a query for any robot
EVERY = "all"
# some ten times the laps of the slowest squat [bytes]
LARGEST_RECORDING = 50_000_000


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
        self._listing = Reading(path, kept)
        self._answers = FeedforwardAnswers(path, kept)
        # the first regression would wait seconds for it
        importlib.import_module("scipy.optimize")
        importlib.import_module("scipy.stats")
        self._service = Service("learner", ANY_ROBOT, place, subject=str(path.resolve()))

    def run(self) -> None:
        """Serve until SIGINT or SIGTERM."""
        with self._service as service:
            # what takes its time waits beside what is looked up in an instant
            self._writes, self._lists = service.line(), service.line()
            self._answers.serve(service.line(), service.instance)
            service.answer("tsd/*/learner/*", self._answer, ANSWERS)
            service.run(f"database {self.path}")
        for opened in (self._answers, self._listing, self._database):
            opened.close()

    def _answer(self, query: zenoh.Query) -> Later | None:
        key = str(query.key_expr)
        robot = robot_of(key)
        answers: dict[str, Callable[[zenoh.Query, str], Later | None]] = {
            feedforward_key(robot): self._answers.feedforward,
            suggestion_key(robot): self._answers.suggestion,
            record_key(robot): self._record,
            database_key(robot): self._entries,
            health_key(robot, "learner"): self._health,
        }
        if key not in answers:
            raise MalformedMessage(f"key {key}", f"one of {', '.join(answers)}")
        return answers[key](query, robot)

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
        listing = Listing.of(texts(query))
        if (number := listing.forget) is None:
            return Later(self._lists, lambda query: self._list(query, robot, listing))
        return Later(self._writes, lambda query: self._forget(query, robot, listing, number))

    def _list(self, query: zenoh.Query, robot: str, listing: Listing) -> None:
        self._reply_list(query, robot, self._page(self._listing, robot, listing))

    def _forget(self, query: zenoh.Query, robot: str, listing: Listing, number: int) -> None:
        forgotten = self._database.forget(number)
        page = self._page(self._database, robot, listing)
        message = None if forgotten is None else EntryMessage.of(forgotten)
        self._reply_list(query, robot, page.model_copy(update={"forgotten": message}))

    def _page(self, reading: Reading, robot: str, listing: Listing) -> DatabaseReply:
        page = reading.outlines(
            None if robot == ANY_ROBOT else robot,
            listing.motion,
            most=listing.limit,
            after=listing.after,
        )
        return DatabaseReply(
            instance=self._service.instance,
            database=str(self.path),
            entries=entry_messages(page.entries),
            damaged=tuple(
                DamagedMessage(entry=each.identifier, reason=each.reason) for each in page.damaged
            ),
            more=page.more,
        )

    def _reply_list(self, query: zenoh.Query, robot: str, reply: DatabaseReply) -> None:
        name = EVERY if robot == ANY_ROBOT else robot
        reply_json(query, database_key(name), reply.encode())

    def _health(self, query: zenoh.Query, robot: str) -> None:
        name = EVERY if robot == ANY_ROBOT else robot
        state = DatabaseStateMessage(**asdict(self._answers.state()))
        reply_json(
            query, health_key(name, "learner"), self._service.health(database=state).encode()
        )
