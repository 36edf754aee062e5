"""An observer that lets others watch: what a run publishes."""

from __future__ import annotations

import os
import secrets
import select
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from time import perf_counter
from typing import Any

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.exceptions import RunDirectoryUnusable
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.repetition.run import Run
from tsd_casadi.state import Vector
from tsd_casadi.tick.layout import hash_layouts
from tsd_casadi.wire.registration import Registration
from tsd_casadi.wire.run_record import RunRecord
from tsd_casadi.wire.telemetry import (
    LapDone,
    RepetitionBegan,
    RepetitionEnded,
    RepetitionMeasured,
    RunEvent,
    RunOver,
)
from tsd_casadi.wire.telemetry_rows import pack_rows
from tsd_clients.telemetry.feed import Feed
from tsd_clients.telemetry.outline import outline_of
from tsd_clients.telemetry.sampling import Sampling

# rows go out together, as often as a picture is drawn [s]
BATCH = 0.04
# for the publishing process to listen: 0.1 s alone, much more where every core is taken [s]
STARTING = 5.0
# for it to take what is left, and to end [s]
ENDING = 1.0


class Telemetry:
    """Publishes one run, which may be of many repetitions, on an endpoint of its own.

    What is published goes through a pipe to a process of its own. The run waits
    neither for that nor for who watches: what there is no room for is dropped.

    Attributes:
        endpoint: Where it can be watched; None before the first repetition, and where
            it cannot.
        trouble: Why it cannot be watched; empty if it can.
        dropped: Rows for which there was no room.
    """

    def __init__(self, robot: str, settings: Mapping[str, Any] | None = None) -> None:
        """Start the publishing process.

        Args:
            settings: What who watches should know of the run, plain data.
        """
        self.endpoint: str | None = None
        self.trouble = ""
        self.dropped = 0
        self.instance = secrets.randbits(63) | 1
        self._robot, self._settings = robot, dict(settings or {})
        self._number, self._repetition, self._laps = 0, 0, 0
        self._learned: tuple[str, ...] = ()
        self._batch: list[Vector] = []
        self._begun = 0.0
        self._registration: Registration | None = None
        self._process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "tsd_clients.telemetry.publisher",
                robot,
                str(self.instance),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        assert self._process.stdin is not None
        self._feed = Feed(os.dup(self._process.stdin.fileno()))
        self._process.stdin.close()

    def __enter__(self) -> Telemetry:
        """Use as a context manager."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, _: object) -> None:
        """Say that the run is over."""
        self.close("" if kind is None else str(error) or kind.__name__)

    def close(self, reason: str = "") -> None:
        """Say that the run is over, and end the publishing process.

        Args:
            reason: What ended it early; empty for nothing.
        """
        if self._feed.is_broken and self._process.returncode is not None:
            return
        self._tell(RunOver, reason=reason)
        self._feed.close(ENDING)
        self._sign_off()
        try:
            self._process.wait(ENDING)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()

    def start(self, setting: Setting) -> None:
        """Say that a repetition begins."""
        self._repetition += 1
        self._laps = 0
        self._learned = setting.axes[: setting.learned]
        self._sampling = Sampling(setting)
        self._layout = hash_layouts([self._sampling.layout])
        if self._repetition == 1:
            self._sign_on(setting.motion.name)
        self._tell(RepetitionBegan, outline=outline_of(setting), settings=self._settings)

    def tick(self, moment: Moment) -> None:
        """Note a tick now and then."""
        row = self._sampling.take(moment)
        if row is not None:
            self._add(row)

    def missed(self, moment: Moment) -> None:
        """Note a period without an answer, as a tick."""
        self.tick(moment)

    def lap(self, lap: Lap) -> None:
        """Say how a lap went."""
        self._flush()
        self._laps += 1
        error = lap.error
        if error is None or not lap.phase.size:
            return  # without an answer in all of it
        about = error - error.mean(axis=1, keepdims=True)
        self._tell(
            LapDone,
            lap=self._laps,
            rms=self._by_axis(np.sqrt(np.mean(error**2, axis=1))),
            ac_rms=self._by_axis(np.sqrt(np.mean(about**2, axis=1))),
            mean_abs_feedback=self._by_axis(np.abs(lap.feedback).mean(axis=1)),
        )

    def end(self, outcome: str) -> None:
        """Say how the repetition ended."""
        self._flush()
        self._tell(RepetitionEnded, outcome=outcome)

    def measured(self, run: Run, notes: Sequence[str] = ()) -> None:
        """Say how a repetition was over its steady laps.

        Args:
            notes: What else people should know of it.
        """
        self._tell(RepetitionMeasured, summary=run.summary(), notes=list(notes))

    def say(self, kind: type[RunEvent], **fields: Any) -> None:
        """Publish something else that happened.

        Args:
            fields: Its fields, without number and repetition.
        """
        self._tell(kind, **fields)

    def _by_axis(self, values: Vector) -> dict[str, float]:
        return dict(zip(self._learned, values.tolist(), strict=True))

    def _add(self, row: Vector) -> None:
        now = perf_counter()
        if not self._batch:
            self._begun = now
        self._batch.append(row)
        if now - self._begun >= BATCH:
            self._flush()

    def _flush(self) -> None:
        if not self._batch:
            return
        body = pack_rows(
            self._layout,
            np.array(self._batch),
            repetition=self._repetition,
            dropped=self.dropped,
            event=self._number,
        )
        if not self._feed.send_rows(body):
            self.dropped += len(self._batch)
        self._batch.clear()

    def _tell(self, kind: type[RunEvent], **fields: Any) -> None:
        self._number += 1
        event = kind(number=self._number, repetition=self._repetition, **fields)
        self._feed.send_event(event.encode())

    def _sign_on(self, motion: str) -> None:
        assert self._process.stdout is not None
        if select.select([self._process.stdout], [], [], STARTING)[0]:
            self.endpoint = self._process.stdout.readline().decode().strip() or None
        if self.endpoint is None:
            self.trouble = "the process that publishes it did not start"
            return
        pid = os.getpid()
        record = RunRecord.of_this_process(
            "run",
            f"{pid}/{self.instance:x}",
            robot=self._robot,
            endpoints=(self.endpoint,),
            instance=self.instance,
            motion=motion,
        )
        try:
            self._registration = Registration(record)
        except (RunDirectoryUnusable, OSError) as error:
            self.trouble = str(error)

    def _sign_off(self) -> None:
        if self._registration is not None:
            with suppress(OSError):
                self._registration.close()
            self._registration = None
