"""The logs of repetitions one after another, a file each."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.repetition.run import Run
from tsd_clients.logs.mcap_log import NONE
from tsd_clients.logs.run_log import RunLog, run_log


class LogSeries:
    """Observes repetitions: 'squat.mcap' becomes 'squat-0.mcap', 'squat-1.mcap' and so on."""

    def __init__(self, path: Path, settings: Mapping[str, Any] = NONE) -> None:
        """Name the files.

        Args:
            path: Ends in .csv, .npz or .mcap.
            settings: Of all runs, plain data.
        """
        self._path, self._settings, self._count = path, settings, 0
        self._log: RunLog | None = None

    def start(self, setting: Setting) -> None:
        """Begin the next file."""
        self._log = run_log(numbered(self._path, self._count), (), self._settings)
        self._count += 1
        self._log.start(setting)

    def tick(self, moment: Moment) -> None:
        """Note a tick."""
        assert self._log is not None
        self._log.tick(moment)

    def missed(self, moment: Moment) -> None:
        """Note a period without an answer."""
        assert self._log is not None
        self._log.missed(moment)

    def lap(self, lap: Lap) -> None:
        """Note a lap."""
        assert self._log is not None
        self._log.lap(lap)

    def end(self, outcome: str) -> None:
        """Note how it ended."""
        assert self._log is not None
        self._log.end(outcome)

    def conclude(self, run: Run) -> None:
        """Write what is known when a repetition is over."""
        assert self._log is not None
        self._log.conclude(run)


def numbered(path: Path, number: int) -> Path:
    """Name the file of a repetition, from 0 on."""
    return path.with_stem(f"{path.stem}-{number}")
