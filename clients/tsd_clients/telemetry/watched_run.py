"""A run that is watched from another process."""

from __future__ import annotations

import time
from collections import deque
from types import TracebackType

import numpy as np

from tsd_casadi.exceptions import TsdError
from tsd_casadi.state import Matrix
from tsd_casadi.tick.layout import Layout, hash_layouts
from tsd_casadi.wire.run_directory import is_stopped, running
from tsd_casadi.wire.run_outline import RunOutline
from tsd_casadi.wire.run_record import RunRecord
from tsd_casadi.wire.telemetry import (
    AnyEvent,
    IterationRecorded,
    LapDone,
    RepetitionBegan,
    RepetitionEnded,
    RepetitionMeasured,
    RunOver,
    RunStory,
    decode_event,
)
from tsd_casadi.wire.telemetry_rows import repetition_of, telemetry_layout, unpack_rows
from tsd_clients.telemetry.run_link import RunLink

# a run that is not found for so long is lost [s]
PATIENCE = 1.0
# of messages that wait for what is said of their repetition
WAITING = 256


def watched_runs() -> list[RunRecord]:
    """List the runs that can be watched here.

    Raises:
        RunDirectoryUnusable: If the run directory is not one.
    """
    return [record for record in running() if record.role == "run" and record.telemetry]


class WatchedRun:
    """What is seen of a run; to be used from one thread, which never waits.

    Everything is as of the last ``take``, which is to be called again and again.

    Attributes:
        record: What the run says of itself in the run directory.
        outline: By which rows are read; None before it is known.
        layout: What the numbers of a row are: those of ``outline.layout`` and, behind
            them, how the ticks since the row before went; None before it is known.
        repetition: Number of the repetition that the rows are of, from 1 on.
        laps: Of that repetition, as far as they are known.
        measured: How the newest repetition was, once that is known.
        outcome: How the repetition ended; empty before that.
        iterations: All that were recorded, the oldest first.
        events: Everything that was told, the oldest first.
        ended: Whether the run is over.
        reason: What ended it early; empty for nothing.
        dropped: Rows that the run itself had no room for.
        trouble: What was received and could not be read; empty for nothing.
    """

    def __init__(self, record: RunRecord) -> None:
        """Begin to watch."""
        self.record = record
        self.outline: RunOutline | None = None
        self.layout: Layout | None = None
        self.repetition = 0
        self.laps: list[LapDone] = []
        self.measured: RepetitionMeasured | None = None
        self.outcome = ""
        self.iterations: list[IterationRecorded] = []
        self.events: list[AnyEvent] = []
        self.ended, self.reason = False, ""
        self.dropped = 0
        self.trouble = ""
        self._link = RunLink(record)
        self._number, self._layout = 0, 0
        self._waiting: deque[tuple[str, bytes]] = deque(maxlen=WAITING)
        self._since = time.monotonic()

    def __enter__(self) -> WatchedRun:
        """Use as a context manager."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Watch no more."""
        self.close()

    def close(self) -> None:
        """Watch no more."""
        self._link.close()

    @property
    def lost(self) -> bool:
        """Whether the run is gone without having said that it is over; it may come back."""
        if self.ended or self._link.is_there:
            return False
        return time.monotonic() - self._since > PATIENCE

    @property
    def is_frozen(self) -> bool:
        """Whether the run's process is stopped, by SIGSTOP or a debugger."""
        return is_stopped(self.record.pid)

    def take(self) -> Matrix:
        """Take what has come since the last time.

        Returns:
            Rows of one repetition, (N, layout.size); those of the next one come with the
            next call. Without any N is 0.
        """
        rows: list[Matrix] = []
        self._listen()
        while self._waiting and self._take_one(rows):
            pass
        size = 0 if self.layout is None else self.layout.size
        return np.concatenate(rows) if rows else np.empty((0, size))

    def _listen(self) -> None:
        was_there = self._link.is_there
        if self._link.look():
            # what was told before, or while the connection was gone
            self._link.ask()
        if was_there and not self._link.is_there:
            self._since = time.monotonic() - PATIENCE
        self._waiting.extend(self._link.messages())
        story = self._link.story()
        if story is not None:
            try:
                for event in RunStory.decode(story).events:
                    self._apply(event)
            except TsdError as error:
                self.trouble = str(error)
        elif self._link.is_there and self.outline is None:
            self._link.ask()

    def _take_one(self, rows: list[Matrix]) -> bool:
        """Take the oldest message, or say that it has to wait."""
        kind, body = self._waiting[0]
        try:
            taken = self._take_rows(body, rows) if kind == "rows" else self._take_event(body, rows)
        except TsdError as error:
            # what cannot be read does not stand in the way of what comes after it
            self.trouble, taken = str(error), True
        if taken:
            self._waiting.popleft()
        return taken

    def _take_rows(self, body: bytes, rows: list[Matrix]) -> bool:
        repetition = repetition_of(body)
        if repetition > self.repetition and self._can_ask():
            return False
        if repetition == self.repetition and self.layout is not None:
            taken = unpack_rows(body, self._layout, self.layout.size)
            self.dropped = taken.dropped
            if taken.event > self._number:
                self._link.ask()
            rows.append(taken.rows)
        return True

    def _take_event(self, body: bytes, rows: list[Matrix]) -> bool:
        event = decode_event(body)
        if isinstance(event, RepetitionBegan) and rows:
            return False
        if event.number > self._number + 1 and self._can_ask():
            return False
        self._apply(event)
        return True

    def _can_ask(self) -> bool:
        """Ask for what was missed, as long as somebody is there to tell it."""
        if self._link.is_there:
            self._link.ask()
        return self._link.is_there

    def _apply(self, event: AnyEvent) -> None:
        if event.number <= self._number:
            return
        self._number = event.number
        self.events.append(event)
        match event:
            case RepetitionBegan():
                self.repetition, self.outline = event.repetition, event.outline
                self.layout = telemetry_layout(event.outline.layout)
                self._layout = hash_layouts([self.layout])
                self.laps, self.outcome = [], ""
            case LapDone():
                self.laps.append(event)
            case RepetitionEnded():
                self.outcome = event.outcome
            case RepetitionMeasured():
                self.measured = event
            case IterationRecorded():
                self.iterations.append(event)
            case RunOver():
                self.ended, self.reason = True, event.reason
