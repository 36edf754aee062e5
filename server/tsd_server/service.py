"""What both services share: session, readiness, liveliness and a clean end."""

from __future__ import annotations

import logging
import secrets
import sys
import threading
import time
from collections.abc import Sequence
from importlib.metadata import version
from types import TracebackType
from typing import Any

import zenoh
from zenoh.handlers import RingChannel

from tsd_casadi.version import __version__
from tsd_casadi.wire.health import DatabaseStateMessage, HealthMessage
from tsd_casadi.wire.keys import alive_key
from tsd_casadi.wire.message import VERSION as MESSAGES
from tsd_casadi.wire.registration import Registration
from tsd_casadi.wire.run_record import RunRecord
from tsd_casadi.wire.tick_message import VERSION as TICK
from tsd_server.answering import Answering
from tsd_server.links import UnhurriedLinks
from tsd_server.place import Place, Role
from tsd_server.say import say
from tsd_server.stop_signals import StopSignals
from tsd_server.waiting_line import WAITING_QUERIES, Answer, WaitingLine

JSON = zenoh.Encoding.APPLICATION_JSON
# how long closing may take: a client that is frozen with a full pipe blocks it [s]
CLOSING = 0.7
# how long a thread that answers something else may keep the ticks waiting for the
# interpreter; with Python's own 5 ms a busy one makes every tick late [s]
SWITCHING = 0.0005

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
        self._declared: list[object] = []  # undeclared when forgotten
        self._failure: BaseException | None = None
        self._answering = Answering(role, self._fail)
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
        end = time.monotonic() + CLOSING
        closing = threading.Thread(target=self.session.close, daemon=True)
        closing.start()
        self._answering.close()
        for thread in (closing, *self._answering.threads):
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
        self._answering.start(queryable, answer, names or key.rpartition("/")[2])

    def line(self) -> WaitingLine:
        """Make a line with a thread of its own, for queries that would keep others waiting."""
        return self._answering.line()

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

    def _fail(self, error: BaseException) -> None:
        self._failure = error
        self._signals.wake()

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
            answers=self._answering.counts(),
            ticks=ticks,
            database=database,
        )


def reply_json(query: zenoh.Query, key: str, body: bytes) -> None:
    """Answer a query with JSON.

    Args:
        key: Key of the reply, without wildcards.
        body: UTF-8 JSON.
    """
    query.reply(key, body, encoding=JSON)
