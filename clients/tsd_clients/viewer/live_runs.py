"""Runs of this machine that publish themselves, found and followed by themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tsd_casadi.tick.layout import Layout
from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.telemetry.watched_run import WatchedRun, watched_runs
from tsd_clients.viewer.rolling import Rolling
from tsd_clients.viewer.shown_run import RunLabel, ShownRun, words_of
from tsd_clients.viewer.ticks import RowReader, Ticks

if TYPE_CHECKING:
    from tsd_casadi.wire.run_record import RunRecord

# a look at the run directory costs some system calls [s]
LOOK = 0.25
# rows that are kept: ten seconds of what is published by the clock, 100 a second
ROWS = 1000
# of runs that are over, so many stay
OVER = 3


class LiveRun:
    """A run that is watched.

    Attributes:
        watched: The subscription, with everything else that it tells.
    """

    def __init__(self, watched: WatchedRun) -> None:
        """Show a run from its next repetition's outline on."""
        self.watched = watched
        self._outline: RunOutline | None = None
        self._label: RunLabel | None = None
        self._reader: RowReader | None = None
        self._rows = Rolling(1, 1)
        self._repetition = 0

    def take(self) -> None:
        """Take in what has come."""
        rows = self.watched.take()
        outline, layout = self.watched.outline, self.watched.layout
        if outline is None or layout is None:
            return
        if outline is not self._outline:
            self._begin(outline, layout)
        if len(rows):
            if self.watched.repetition != self._repetition:
                # time begins anew
                self._rows = Rolling(ROWS, layout.size)
                self._repetition = self.watched.repetition
            self._rows.add(rows)

    @property
    def is_known(self) -> bool:
        """Whether it said what it is."""
        return self._label is not None

    @property
    def label(self) -> RunLabel:
        """What it is, once it is known."""
        assert self._label is not None
        return self._label

    @property
    def state(self) -> str:
        """How it is."""
        watched = self.watched
        if watched.ended:
            return f"over: {watched.reason or watched.outcome or 'done'}"
        if watched.lost:
            return "lost"
        if watched.is_frozen:
            return f"frozen: process {watched.record.pid} is stopped"
        if watched.outcome:
            return f"repetition {watched.repetition} {watched.outcome}, between two"
        return f"running, repetition {watched.repetition}"

    @property
    def is_over(self) -> bool:
        """Whether nothing comes any more."""
        return self.watched.ended or self.watched.lost

    @property
    def ticks(self) -> Ticks:
        """The newest ticks."""
        assert self._reader is not None
        return self._reader.ticks(self._rows.rows)

    def _begin(self, outline: RunOutline, layout: Layout) -> None:
        known = outline.known
        self._outline = outline
        self._reader = RowReader(outline, layout)
        if len(self._rows.rows) == 0 or self._rows.rows.shape[1] != layout.size:
            self._rows = Rolling(ROWS, layout.size)
        self._label = RunLabel(
            key=f"{self.watched.record.instance:x}",
            robot=outline.robot,
            robot_file=outline.robot_file,
            model=outline.model,
            motion=outline.motion,
            parameters=words_of(outline.parameters),
            axes=outline.axes,
            learned=outline.learned,
            joints=known.joints,
            contacts=known.contacts,
            all_axes=known.axes,
            limit_rows=known.row_names,
            torque_limits=np.array(outline.torque_limits),
        )


class LiveRuns:
    """Polled by the page; runs that are over stay until others take their place."""

    def __init__(self) -> None:
        """Begin to look."""
        self._runs: dict[int, LiveRun] = {}
        self._looked = float("-inf")

    @property
    def live(self) -> tuple[LiveRun, ...]:
        """All that are followed and known, those that began first in front."""
        return tuple(run for run in self._runs.values() if run.is_known)

    @property
    def shown(self) -> tuple[ShownRun, ...]:
        """What is seen of them."""
        return self.live

    def poll(self, now: float) -> None:
        """Look for runs, and take in what they published."""
        if now >= self._looked + LOOK:
            self._looked = now
            for record in watched_runs():
                if record.instance not in self._runs:
                    self._follow(record)
        for run in self._runs.values():
            run.take()

    def close(self) -> None:
        """Watch no more."""
        for run in self._runs.values():
            run.watched.close()

    def _follow(self, record: RunRecord) -> None:
        """Follow a run; one of the same robot that is over goes."""
        over = [key for key, run in self._runs.items() if run.is_over]
        of_robot = [key for key in over if self._runs[key].watched.record.robot == record.robot]
        others = [key for key in over if key not in of_robot]
        for key in of_robot + others[: len(others) - OVER if len(others) > OVER else 0]:
            self._runs.pop(key).watched.close()
        self._runs[record.instance] = LiveRun(WatchedRun(record))
