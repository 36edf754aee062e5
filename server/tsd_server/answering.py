"""Answering queries: taken up in turn, counted, and refused with a reason."""

from __future__ import annotations

import logging
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import zenoh

from tsd_casadi.exceptions import TsdError
from tsd_casadi.wire.error import ErrorMessage
from tsd_casadi.wire.health import AnswersMessage
from tsd_server.say import say
from tsd_server.tally import Tally
from tsd_server.waiting_line import WAITING_QUERIES, Answer, Taken, WaitingLine

JSON = zenoh.Encoding.APPLICATION_JSON
# where queries are counted whose key ends in none of the words that are named
OTHER = "other"

_log = logging.getLogger(__name__)


class Answering:
    """The threads of a service that answer, each for one queryable or line.

    Attributes:
        threads: They end when the session and ``close`` have ended what they wait for.
    """

    def __init__(self, role: str, on_failure: Callable[[BaseException], None]) -> None:
        """Answer nothing yet.

        Args:
            role: 'controller' or 'learner'.
            on_failure: Called in a thread that cannot go on, unless it was closed.
        """
        self.threads: list[threading.Thread] = []
        self._role = role
        self._on_failure = on_failure
        self._is_closing = False
        self._lines: list[WaitingLine] = []
        self._tallies: dict[str, Tally] = {}

    def start(self, queryable: Any, answer: Answer, names: Sequence[str] | str) -> None:
        """Answer the queries of a queryable.

        Args:
            names: Name to count them by, or several: then the last word of their key,
                whatever is none of them as 'other'.
        """
        for name in (names,) if isinstance(names, str) else (*names, OTHER):
            self._tallies.setdefault(name, Tally())
        self._start(self._in_turn(queryable, answer, names))

    def line(self) -> WaitingLine:
        """Make a line with a thread of its own."""
        line = WaitingLine()
        self._lines.append(line)
        self._start(iter(line.take, None))
        return line

    def counts(self) -> dict[str, AnswersMessage]:
        """Say what became of the queries, by name."""
        return {name: tally.message() for name, tally in self._tallies.items()}

    def close(self) -> None:
        """Let nobody wait any more; failures are not told from here on."""
        self._is_closing = True
        for line in self._lines:
            line.close()

    def _start(self, queries: Iterable[Taken]) -> None:
        thread = threading.Thread(target=self._loop, args=(queries,), daemon=True)
        self.threads.append(thread)
        thread.start()

    def _loop(self, queries: Iterable[Taken]) -> None:
        try:
            for taken in queries:
                self._answer_one(taken)
        except BaseException as error:
            if not self._is_closing:
                self._on_failure(error)

    def _in_turn(
        self, queryable: Any, answer: Answer, names: Sequence[str] | str
    ) -> Iterator[Taken]:
        """Take up queries in the order in which they came, until the session is closed.

        Some of those that have come are taken up before the next is answered, since
        only what has been taken up can be counted.
        """
        waiting: deque[Taken] = deque()
        for query in queryable:
            waiting.append(self._take(query, answer, names))
            while waiting:
                while len(waiting) < WAITING_QUERIES and (more := queryable.try_recv()) is not None:
                    waiting.append(self._take(more, answer, names))
                yield waiting.popleft()

    def _take(self, query: Any, answer: Answer, names: Sequence[str] | str) -> Taken:
        name = names
        if not isinstance(name, str):
            name = str(query.key_expr).rpartition("/")[2]
            name = name if name in names else OTHER
        tally = self._tallies[name]
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
