"""What both services share: session, readiness, liveliness and a clean end."""

from __future__ import annotations

import secrets
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from types import TracebackType
from typing import Any, TextIO

import zenoh
from zenoh.handlers import RingChannel

from tsd_casadi.exceptions import EndpointTaken, TsdError
from tsd_casadi.wire.endpoints import check_endpoint, configure_runtime, session_settings
from tsd_casadi.wire.error import ErrorMessage
from tsd_casadi.wire.keys import alive_key
from tsd_server.stop_signals import StopSignals
from tsd_server.waiting_line import WAITING_QUERIES, Later, WaitingLine

JSON = zenoh.Encoding.APPLICATION_JSON
# how long closing may take: a client that is frozen with a full pipe blocks it [s]
CLOSING = 0.7

Answer = Callable[[zenoh.Query], Later | None]


class Service:
    """A Zenoh session that answers queries until it is told to stop.

    Each queryable has a thread and a channel of its own, so a query is
    answered outside Zenoh's threads and the process can always end.

    Attributes:
        instance: Random id of this service, in every reply.
        session: The session.
    """

    def __init__(
        self, role: str, robot: str, listen: Sequence[str], *, low_latency: bool = False
    ) -> None:
        """Open the session.

        Args:
            role: 'controller' or 'learner'.
            robot: Robot's chunk of the keys.
            listen: Endpoints to listen on.
            low_latency: See ``session_settings``.

        Raises:
            EndpointTaken: If it cannot listen there.
            InvalidValue: If an endpoint is malformed.
        """
        self.instance = secrets.randbits(63) | 1
        self._role = role
        self._robot = robot
        self._listen = [check_endpoint(endpoint) for endpoint in listen]
        self._closing = False
        self._threads: list[threading.Thread] = []
        self._lines: list[WaitingLine] = []
        self._declared: list[object] = []  # undeclared when forgotten
        self._failure: BaseException | None = None
        configure_runtime()
        zenoh.init_log_from_env_or("off")
        config = zenoh.Config()
        for key, value in session_settings(listen=self._listen, low_latency=low_latency).items():
            config.insert_json5(key, value)
        try:
            self.session = zenoh.open(config)
        except zenoh.ZError as error:
            raise EndpointTaken(role, ", ".join(self._listen), _reason(error)) from error
        self._signals = StopSignals()

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

    def answer(self, key: str, answer: Answer) -> None:
        """Answer the queries on a key, one after another.

        Under overload the oldest waiting queries are dropped, which their
        clients notice at once. The channel must never block: Zenoh's own thread
        would wait with it, keep-alives would stop and every client be cut off.

        Args:
            answer: Replies to one query, or says in which line it is to wait; a
                TsdError it raises becomes an error reply.
        """
        queryable: Any = self.session.declare_queryable(
            key, RingChannel(WAITING_QUERIES), complete=True
        )
        self._declared.append(queryable)
        pairs = ((query, answer) for query in queryable)  # ends when the session is closed
        self._start(pairs)

    def line(self) -> WaitingLine:
        """Make a line with a thread of its own, for queries that would keep others waiting."""
        line = WaitingLine()
        self._lines.append(line)
        self._start(iter(line.take, None))
        return line

    def _start(self, queries: Iterable[tuple[zenoh.Query, Answer]]) -> None:
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
            for endpoint in self._listen:
                say(f"{self._role} ready on {endpoint}: {description}", sys.stdout)
            self._signals.wait()
        if self._failure is not None:
            raise self._failure

    def _loop(self, queries: Iterable[tuple[zenoh.Query, Answer]]) -> None:
        try:
            for query, answer in queries:
                self._answer_one(query, answer)
        except BaseException as error:
            if not self._closing:
                self._failure = error
                self._signals.wake()

    def _answer_one(self, query: zenoh.Query, answer: Answer) -> None:
        later = None
        try:
            later = answer(query)
        except TsdError as error:
            query.reply_err(ErrorMessage.of(error).encode(), encoding=JSON)
        except Exception as error:
            # the client must not wait for its timeout because of our defect
            message = ErrorMessage(
                format="tsd.error/2",
                code="internal",
                message=f"{self._role} failed: {type(error).__name__}: {error}",
            )
            query.reply_err(message.encode(), encoding=JSON)
            say(message.message, sys.stderr)
        finally:
            if later is None:
                # or its client would wait for more
                query.drop()  # type: ignore[no-untyped-call]
        if later is not None:
            later.line.put(query, later.answer)


def say(text: str, stream: TextIO) -> None:
    """Tell the user; that nobody reads it is no reason to stop serving.

    Args:
        text: One line.
        stream: Standard output or error.
    """
    with suppress(OSError, ValueError):
        print(text, file=stream, flush=True)


def _reason(error: Exception) -> str:
    # Zenoh's text goes on with its own source lines
    text = str(error)
    if "Address already in use" in text:
        return "the address is already in use"
    return text.split(" at /", maxsplit=1)[0] or type(error).__name__


def reply_json(query: zenoh.Query, key: str, body: bytes) -> None:
    """Answer a query with JSON.

    Args:
        key: Key of the reply, without wildcards.
        body: UTF-8 JSON.
    """
    query.reply(key, body, encoding=JSON)
