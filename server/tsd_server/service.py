"""What both services share: session, readiness, liveliness and a clean end."""

from __future__ import annotations

import logging
import secrets
import sys
import threading
import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import version
from types import TracebackType
from typing import Any, TextIO

import zenoh
from zenoh.handlers import RingChannel

from tsd_casadi.exceptions import TsdError
from tsd_casadi.version import __version__
from tsd_casadi.wire.error import ErrorMessage
from tsd_casadi.wire.health import DatabaseStateMessage, HealthMessage
from tsd_casadi.wire.keys import alive_key
from tsd_casadi.wire.message import VERSION as MESSAGES
from tsd_casadi.wire.run_directory import Registration, RunRecord
from tsd_casadi.wire.tick_message import VERSION as TICK
from tsd_server.links import UnhurriedLinks
from tsd_server.place import Place, Role
from tsd_server.stop_signals import StopSignals
from tsd_server.tally import Tally
from tsd_server.waiting_line import WAITING_QUERIES, Answer, Taken, WaitingLine

JSON = zenoh.Encoding.APPLICATION_JSON
# how long closing may take: a client that is frozen with a full pipe blocks it [s]
CLOSING = 0.7
# how long a thread that answers something else may keep the ticks waiting for the
# interpreter; with Python's own 5 ms a busy one makes every tick late [s]
SWITCHING = 0.0005

# where queries are counted on a key with a wildcard that is none of those named
OTHER = "other"

_log = logging.getLogger(__name__)


class Service:
    """A Zenoh session that answers queries until it is told to stop.

    Each queryable has a thread and a channel of its own, so a query is
    answered outside Zenoh's threads and the process can always end.

    Attributes:
        instance: Random id of this service, in every reply.
        session: The session.
    """

    def __init__(self, role: Role, robot: str, place: Place, *, subject: str | None = None) -> None:
        """Take the place and open the session.

        Args:
            role: 'controller' or 'learner'.
            robot: Robot's chunk of the keys.
            place: Where to listen.
            subject: What is served once on this machine; the robot by default.

        Raises:
            AlreadyRunning: If another service of the role serves the subject.
            EndpointTaken: If it cannot listen there.
            InvalidValue: If an endpoint or the file of the place is malformed.
            CertificateRefused: If a certificate cannot be used.
        """
        self.instance = secrets.randbits(63) | 1
        self._role = role
        self._robot = robot
        self._endpoints = place.endpoints(role)
        self._closing = False
        self._threads: list[threading.Thread] = []
        self._lines: list[WaitingLine] = []
        self._declared: list[object] = []  # undeclared when forgotten
        self._tallies: dict[str, Tally] = {}
        self._failure: BaseException | None = None
        self._record = RunRecord.of_this_process(
            role,
            subject or robot,
            robot=robot,
            endpoints=tuple(self._endpoints),
            instance=self.instance,
        )
        # looked up once: a look at the disk for each query would keep the ticks waiting
        self._versions = {
            "tsd_casadi": __version__,
            "zenoh": version("eclipse-zenoh"),
            "messages": str(MESSAGES),
            "tick": str(TICK),
        }
        self._opened = time.monotonic()
        self._registration = Registration(self._record)
        try:
            self.session = place.open(role)
        except BaseException:
            self._registration.close()
            raise
        sys.setswitchinterval(SWITCHING)
        self._links = UnhurriedLinks(self.session)
        self._signals = StopSignals()
        _log.info("%s of %s opened its session", role, subject or robot)

    def __enter__(self) -> Service:
        """Use as a context manager."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the session and wait for the answers under way, but not for long."""
        self._closing = True
        end = time.monotonic() + CLOSING
        closing = threading.Thread(target=self.session.close, daemon=True)
        closing.start()
        for line in self._lines:
            line.close()
        for thread in (closing, *self._threads):
            thread.join(max(0.0, end - time.monotonic()))
        self._signals.close()
        self._registration.close()
        _log.info("%s of %s has closed", self._role, self._record.subject)

    def answer(self, key: str, answer: Answer, names: Sequence[str] = ()) -> None:
        """Answer the queries on a key, one after another.

        Under overload the oldest waiting queries are dropped, which their
        clients notice at once. The channel must never block: Zenoh's own thread
        would wait with it, keep-alives would stop and every client be cut off.

        Args:
            answer: Replies to one query, or says in which line it is to wait; a
                TsdError it raises becomes an error reply.
            names: Last words of keys to count by, where the key ends in a wildcard.
        """
        queryable: Any = self.session.declare_queryable(
            key, RingChannel(WAITING_QUERIES), complete=True
        )
        self._declared.append(queryable)
        named = dict.fromkeys([*names, OTHER] if names else [key.rpartition("/")[2]])
        for name in named:
            self._tallies.setdefault(name, Tally())
        self._start(self._in_turn(queryable, answer))

    def line(self) -> WaitingLine:
        """Make a line with a thread of its own, for queries that would keep others waiting."""
        line = WaitingLine()
        self._lines.append(line)
        self._start(iter(line.take, None))
        return line

    def _start(self, queries: Iterable[Taken]) -> None:
        thread = threading.Thread(target=self._loop, args=(queries,), daemon=True)
        self._threads.append(thread)
        thread.start()

    def run(self, description: str) -> None:
        """Say that the service is ready and wait for SIGINT or SIGTERM.

        Args:
            description: What is served, for people.

        Raises:
            TsdError: If answering failed in a way that is no client's fault.
        """
        token = alive_key(self._robot, self._role)
        with self._signals:
            self._declared.append(self.session.liveliness().declare_token(token))
            for endpoint in self._endpoints:
                say(f"{self._role} ready on {endpoint}: {description}", sys.stdout)
            self._signals.wait()
        if self._failure is not None:
            raise self._failure

    def health(
        self,
        *,
        ticks: dict[str, int] | None = None,
        database: DatabaseStateMessage | None = None,
    ) -> HealthMessage:
        """Say how the service is.

        Args:
            ticks: Of a controller, by status.
            database: Of a learner.
        """
        return HealthMessage(
            role=self._role,
            robot=self._robot,
            instance=self.instance,
            pid=self._record.pid,
            started=self._record.started,
            uptime=time.monotonic() - self._opened,
            versions=self._versions,
            answers={name: tally.message() for name, tally in self._tallies.items()},
            ticks=ticks,
            database=database,
        )

    def _loop(self, queries: Iterable[Taken]) -> None:
        try:
            for taken in queries:
                self._answer_one(taken)
        except BaseException as error:
            if not self._closing:
                self._failure = error
                self._signals.wake()

    def _in_turn(self, queryable: Any, answer: Answer) -> Iterator[Taken]:
        """Take up queries in the order in which they came, until the session is closed.

        Some of those that have come are taken up before the next is answered, since
        only what has been taken up can be counted.
        """
        waiting: deque[Taken] = deque()
        for query in queryable:
            waiting.append(self._take(query, answer))
            while waiting:
                while len(waiting) < WAITING_QUERIES and (more := queryable.try_recv()) is not None:
                    waiting.append(self._take(more, answer))
                yield waiting.popleft()

    def _take(self, query: zenoh.Query, answer: Answer) -> Taken:
        name = str(query.key_expr).rpartition("/")[2]
        tally = self._tallies.get(name) or self._tallies[OTHER]
        tally.take()
        return Taken(query, answer, tally)

    def _answer_one(self, taken: Taken) -> None:
        query, later = taken.query, None
        try:
            later = taken.answer(query)
            if later is None:
                taken.tally.answer(taken.since)
        except TsdError as error:
            taken.tally.refuse(error.code, taken.since)
            _log.debug("%s refused: %s", query.key_expr, error)
            query.reply_err(ErrorMessage.of(error).encode(), encoding=JSON)
        except Exception as error:
            taken.tally.fail(type(error).__name__, taken.since)
            # the client must not wait for its timeout because of our defect
            message = ErrorMessage(
                format="tsd.error/2",
                code="internal",
                message=f"{self._role} failed: {type(error).__name__}: {error}",
            )
            query.reply_err(message.encode(), encoding=JSON)
            say(message.message, sys.stderr)
            _log.info("%s failed", query.key_expr, exc_info=error)
        finally:
            if later is None:
                # or its client would wait for more
                taken.drop()
        if later is not None:
            later.line.put(replace(taken, answer=later.answer))


def say(text: str, stream: TextIO) -> None:
    """Tell the user; that nobody reads it is no reason to stop serving.

    Args:
        text: One line.
        stream: Standard output or error.
    """
    with suppress(OSError, ValueError):
        print(text, file=stream, flush=True)


def reply_json(query: zenoh.Query, key: str, body: bytes) -> None:
    """Answer a query with JSON.

    Args:
        key: Key of the reply, without wildcards.
        body: UTF-8 JSON.
    """
    query.reply(key, body, encoding=JSON)
