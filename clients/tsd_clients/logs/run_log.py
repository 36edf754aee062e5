"""The log of a run, in whatever file the user asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.observer import Observer
from tsd_casadi.repetition.run import Run
from tsd_clients.logs.log_file import MCAP, save_log
from tsd_clients.logs.mcap_log import NONE, McapLog
from tsd_clients.telemetry.outline import outline_of


class RunLog(Observer, Protocol):
    """Observes a repetition and writes it down."""

    def conclude(self, run: Run) -> None:
        """Write what is known when it is over, also of one that was aborted."""


class WholeLog:
    """A file that is written in the end, .npz or .csv: ticks are in memory anyway."""

    def __init__(self, path: Path) -> None:
        """Name the file."""
        self._path = path

    def start(self, setting: Setting) -> None:
        """Note what the repetition is about."""
        self._outline = outline_of(setting)

    def tick(self, moment: Moment) -> None:
        """Note nothing: the run has every tick."""

    def missed(self, moment: Moment) -> None:
        """Note nothing: the run has every period."""

    def lap(self, lap: Lap) -> None:
        """Note nothing."""

    def end(self, outcome: str) -> None:
        """Note nothing."""

    def conclude(self, run: Run) -> None:
        """Write the file.

        Raises:
            InvalidValue: If it cannot be written.
        """
        save_log(run, self._path, self._outline)


def run_log(
    path: Path, compensators: Sequence[Compensator] = (), settings: Mapping[str, Any] = NONE
) -> RunLog:
    """Choose how a run is written down, by the ending of the file.

    Args:
        path: Ends in .csv, .npz or .mcap.
        compensators: Of the run.
        settings: Of the run, plain data; a .mcap has them also of a run that is killed.

    Raises:
        InvalidValue: If it has another ending.
        NotAvailable: If the library of its format is not installed.
    """
    return McapLog(path, compensators, settings) if path.suffix.lower() == MCAP else WholeLog(path)
