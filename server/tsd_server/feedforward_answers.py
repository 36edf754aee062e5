"""What to feed forward, and where to learn next: looked up at once, or generalised in a line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import zenoh

from tsd_casadi.database.database_state import DatabaseState
from tsd_casadi.database.kept_entries import KeptEntries
from tsd_casadi.database.reading import Reading
from tsd_casadi.exceptions import EntryNotFound, InvalidValue, MalformedMessage
from tsd_casadi.wire.feedforward import FeedforwardMessage
from tsd_casadi.wire.keys import ANY_ROBOT, feedforward_key, suggestion_key
from tsd_casadi.wire.question import Question, number
from tsd_casadi.wire.suggestion import SuggestionMessage
from tsd_server.kept_replies import KeptReplies
from tsd_server.service import reply_json
from tsd_server.waiting_line import Later, WaitingLine

QUERY = "?motion=squat;amplitude=0.05;frequency=0.25"
REGION = "?motion=squat;amplitude=0.02:0.08;frequency=0.2:0.6"


class FeedforwardAnswers:
    """Answers from a database file, in the service's thread and in a line of its own."""

    def __init__(self, path: Path, kept: KeptEntries) -> None:
        """Open a file that a ``Database`` has opened.

        Args:
            kept: Decoded entries, shared with whoever writes.
        """
        # a connection for each thread
        self._exact, self._fitting = Reading(path, kept), Reading(path, kept)
        self._replies = KeptReplies()

    def serve(self, line: WaitingLine, instance: int) -> None:
        """Take what is known once the service is there.

        Args:
            line: For what takes its time.
            instance: Id of the service.
        """
        self._line, self._instance = line, instance

    def close(self) -> None:
        """Close the file."""
        self._exact.close()
        self._fitting.close()

    def state(self) -> DatabaseState:
        """Tell how the file is, in the service's thread."""
        return self._exact.state()

    def feedforward(self, query: zenoh.Query, robot: str) -> Later | None:
        """Answer with the entry asked for, or say that it has to be generalised.

        Raises:
            TsdError: What ``Reading.query`` raises.
        """
        if robot == ANY_ROBOT:
            raise MalformedMessage("a feedforward for any robot", "the robot's name in the key")
        asked_texts = texts(query)
        question = robot, *sorted(asked_texts.items())  # in whatever order they come
        body = self._replies.find(question, self._exact.version())
        if body is None:
            asked = Question.of(asked_texts, QUERY)
            if asked.kind == "generalised":
                return self._generalize_later(robot, asked)
            try:
                body = self._ask(robot, replace(asked, kind="learned"), self._exact)
            except EntryNotFound:
                if asked.kind == "learned":
                    raise
                return self._generalize_later(robot, asked)
            self._replies.keep(question, body, self._exact.version())
        reply_json(query, feedforward_key(robot), body)
        return None

    def suggestion(self, query: zenoh.Query, robot: str) -> Later:
        """Say where to learn next, in the line."""
        return Later(self._line, lambda query: self._suggest(query, robot))

    def _generalize_later(self, robot: str, asked: Question) -> Later:
        def answer(query: zenoh.Query) -> None:
            reply_json(query, feedforward_key(robot), self._ask(robot, asked, self._fitting))

        return Later(self._line, answer)

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
        return FeedforwardMessage.of(robot, asked.motion, feedforward, self._instance).encode()

    def _suggest(self, query: zenoh.Query, robot: str) -> None:
        if robot == ANY_ROBOT:
            raise MalformedMessage("a suggestion for any robot", "the robot's name in the key")
        asked = Question.of(texts(query), REGION)
        if asked.kind is not None or asked.extrapolate:
            raise InvalidValue("the query", "with kind or extrapolate", f"neither, as in {REGION}")
        region, fixed = _region(asked.parameters)
        suggestion = self._fitting.suggest(
            asked.motion,
            robot=robot,
            region=region,
            axes=asked.axes,
            context=asked.context,
            version=asked.version,
            **fixed,
        )
        message = SuggestionMessage.of(robot, asked.motion, suggestion, self._instance)
        reply_json(query, suggestion_key(robot), message.encode())


def _region(
    given: Mapping[str, str],
) -> tuple[dict[str, tuple[float, float]], dict[str, float]]:
    """Tell ranges 'low:high' from numbers."""
    region, fixed = {}, {}
    for name, text in given.items():
        low, colon, high = text.partition(":")
        if colon:
            region[name] = number(name, low), number(name, high)
        else:
            fixed[name] = number(name, text)
    return region, fixed


def texts(query: zenoh.Query) -> dict[str, str]:
    """Read the selector's parameters."""
    # the stub does not know that Parameters iterate over pairs
    pairs = list(dict(query.parameters).items())  # type: ignore[call-overload]
    return {str(name): str(value) for name, value in pairs}
