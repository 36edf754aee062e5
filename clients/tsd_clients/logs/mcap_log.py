"""The log of a run as an MCAP file, written by a process of its own while the robot moves."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.exceptions.logs import LogNotWritten
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.run import Run
from tsd_casadi.repetition.tick_row import TickRow
from tsd_casadi.tick.format import Status
from tsd_clients.logs import write_mcap
from tsd_clients.logs.log_file import check_log_path
from tsd_clients.logs.run_summary import run_summary
from tsd_clients.logs.unblocked_pipe import UnblockedPipe
from tsd_clients.telemetry.outline import outline_of

# s; loading Python from a slow disk
PATIENCE = 60.0
NONE: Mapping[str, Any] = MappingProxyType({})


class McapLog:
    """Observes a repetition: notes rows and hands them over, and never waits during it.

    A writer that ends early, as on a full disk, costs the rest of the log and nothing
    else; ``conclude`` tells.

    Attributes:
        path: The file.
    """

    def __init__(
        self,
        path: Path,
        compensators: Sequence[Compensator] = (),
        settings: Mapping[str, Any] = NONE,
    ) -> None:
        """Prepare; the file is made when the repetition begins.

        Args:
            path: The file.
            compensators: Of the repetition; when one drops the feedforward is noted.
            settings: Of the run as far as they are known before it, plain data.

        Raises:
            NotAvailable: If the library that writes it is not installed.
        """
        check_log_path(path)
        self.path, self._settings = path, dict(settings)
        self._compensators = list(compensators)

    def start(self, setting: Setting) -> None:
        """Start the writer and wait until its file is open.

        Raises:
            LogNotWritten: If it cannot be.
        """
        self._row, self._has_request = TickRow(setting), False
        self._vetoes = [each for each in self._compensators]
        # a file: nobody reads what the writer says before it has ended
        self._words = tempfile.TemporaryFile()  # noqa: SIM115
        source, target = os.pipe()
        self._pipe = UnblockedPipe(target)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", write_mcap.__name__, str(self.path)],
                stdin=source,
                stdout=subprocess.PIPE,
                stderr=self._words,
                # Ctrl-C is for the run; its end is told by the pipe. Not a session of its own:
                # Linux shares cores out between sessions, whatever their niceness
                process_group=0,
            )
        finally:
            os.close(source)
        began = write_mcap.BEGAN.pack(time.time_ns())
        self._pipe.put(write_mcap.OUTLINE, began + outline_of(setting).encode())
        self._pipe.put(write_mcap.SETTINGS, json.dumps(self._settings).encode())
        self._wait_until_ready()

    def tick(self, moment: Moment) -> None:
        """Note a tick, and what is told of the first one without a solution."""
        self._pipe.put(write_mcap.ROW, self._row.of(moment).tobytes())
        assert moment.tick is not None
        if not self._has_request and moment.tick.reply[0] == Status.INFEASIBLE:
            self._has_request = True
            self._pipe.put(write_mcap.REQUEST, moment.command.request.tobytes())
        self._note_vetoes()

    def missed(self, moment: Moment) -> None:
        """Note a period without an answer."""
        self._pipe.put(write_mcap.ROW, self._row.of(moment).tobytes())
        self._note_vetoes()

    def lap(self, lap: Lap) -> None:
        """Note nothing: ticks have the number of their lap."""

    def end(self, outcome: str) -> None:
        """Wait until the writer has all that there is."""
        known: dict[str, Any] = {"fell": outcome == "fell", "steady": outcome == "steady"}
        if outcome == "aborted":
            known["aborted"] = "the run was aborted"
        self._pipe.put(write_mcap.OUTCOME, json.dumps(known).encode())
        self._pipe.flush()

    def conclude(self, run: Run) -> None:
        """Add what the run says of itself, and make the file whole.

        Raises:
            LogNotWritten: If the file ends before the run did.
        """
        self._pipe.put(write_mcap.SUMMARY, json.dumps(run_summary(run)).encode())
        self._pipe.flush()
        self.close()

    def close(self) -> None:
        """Make the file whole as it is.

        Raises:
            LogNotWritten: If it cannot be.
        """
        self._pipe.close()
        code = self._process.wait()
        reason = self._reason()
        if code != 0:
            raise LogNotWritten(self.path, reason)

    @property
    def writer(self) -> int:
        """Number of the process that writes."""
        return self._process.pid

    def _note_vetoes(self) -> None:
        for each in self._vetoes:
            if each.veto is not None:
                self._vetoes.remove(each)
                self._pipe.put(write_mcap.VETO, each.veto.encode())
                return

    def _wait_until_ready(self) -> None:
        stdout = self._process.stdout
        assert stdout is not None
        with stdout:
            readable, _, _ = select.select([stdout], [], [], PATIENCE)
            if readable and stdout.readline() == write_mcap.READY:
                return
        self._process.kill()
        self._process.wait()
        self._pipe.close()
        reason = self._reason()
        if not readable:
            reason = f"its writer did not start within {PATIENCE:g} s"
        raise LogNotWritten(self.path, reason)

    def _reason(self) -> str:
        with self._words as words:
            words.seek(0)
            lines = words.read().decode(errors="replace").strip().splitlines()
        code = self._process.returncode
        if lines:
            return lines[-1]
        return f"its writer was killed by signal {-code}" if code < 0 else f"it ended with {code}"
