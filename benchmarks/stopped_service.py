"""One service, from its start to the signal that ends it, and what is left of it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tsd_casadi.exceptions import TsdError
from tsd_casadi.wire.keys import ANY_ROBOT, database_key, info_key
from tsd_clients.remote.session import Session
from tsd_server.service_process import free_endpoint

ROBOT = "hermes_lower"
PATIENCE = 10.0  # s, for a service to end after its first signal
GRACE = 0.5  # s, for the kernel to take away what was killed
DEFECTS = ("Traceback", "Exception ignored", "Fatal Python error", "panicked at")


@dataclass(frozen=True)
class Stop:
    """How a service took its first signal.

    Attributes:
        phase: 'starting', 'compiling' or 'serving', by what it had printed.
        signal: Number of the signal.
        moment: From the start of the process to the signal [s].
        duration: From the signal to the end of the process [s]; None for no end.
        exit_code: Negative where a signal ended it.
        traceback: What a user should never see: 'ours', 'python' if the interpreter
            had not come to our first line yet, or empty.
        orphans: Processes it had started that were still running.
        left_behind: Temporary files and folders it left.
        printed: All that it printed, if there is something wrong.
    """

    role: str
    phase: str
    signal: int
    moment: float
    duration: float | None
    exit_code: int
    traceback: str
    orphans: int
    left_behind: list[str]
    printed: str


class RunningService:
    """A service as a process of a session of its own, which is asked while it serves."""

    def __init__(self, role: str, cache: Path, folder: str) -> None:
        """Start it with a cache, empty if it is to compile, and an empty folder."""
        self.role = role
        self._cache = cache
        self._temporary = Path(folder) / "temporary"
        self._temporary.mkdir()
        self.endpoint = free_endpoint()
        options = ["--listen", self.endpoint]
        if role == "learner":
            options += ["--database", str(Path(folder) / "feedforward.sqlite")]
        self.started = time.monotonic()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tsd_server", role, *options],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
            env={
                **os.environ,
                "TSD_CACHE_DIR": str(cache),
                "TSD_RUN_DIR": str(Path(folder) / "run"),
                "TMPDIR": str(self._temporary),
            },
        )
        self._lines: list[str] = []
        self.is_ready = threading.Event()
        self._is_over = threading.Event()
        self._reading = threading.Thread(target=self._read)
        self._asking = threading.Thread(target=self._ask)
        self._reading.start()
        self._asking.start()

    def __enter__(self) -> RunningService:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """End what still runs, whatever happened."""
        self.process.kill()
        self.process.wait()
        self._reading.join()
        self._asking.join()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as lines:
            for line in lines:
                self._lines.append(line)
                if " ready on " in line:
                    self.is_ready.set()
        self._is_over.set()
        self.is_ready.set()

    def _ask(self) -> None:
        """Keep it answering, so that the signal does not always meet a sleeping service."""
        self.is_ready.wait()
        key = info_key(ROBOT) if self.role == "controller" else database_key(ANY_ROBOT)
        try:
            session = Session(self.role, [self.endpoint])
        except TsdError:
            return
        while not self._is_over.is_set():
            try:
                session.query(key, timeout=0.2)
            except TsdError:
                time.sleep(0.01)
        session.close()

    def stop(self, number: int) -> Stop:
        """Send one signal, by its number, and look at what comes of it."""
        printed = "".join(self._lines)
        words = {" ready on ": "serving", "compiling": "compiling", "": "starting"}
        phase = next(phase for word, phase in words.items() if word in printed)
        sent = time.monotonic()
        self.process.send_signal(number)
        try:
            exit_code = self.process.wait(PATIENCE)
            duration = time.monotonic() - sent
        except subprocess.TimeoutExpired:
            duration = None
            self.process.kill()
            exit_code = self.process.wait()
        orphans = self._end_orphans()
        self._reading.join()
        self._asking.join()
        printed = "".join(self._lines)
        traceback = ""
        if any(word in printed for word in DEFECTS):
            traceback = "ours" if "tsd_" in printed else "python"
        left_behind = [path.name for path in self._cache.glob("build-*")]
        left_behind += [path.name for path in self._temporary.iterdir()]
        is_well = duration is not None and not (traceback or orphans or left_behind)
        return Stop(
            role=self.role,
            phase=phase,
            signal=number,
            moment=sent - self.started,
            duration=duration,
            exit_code=exit_code,
            traceback=traceback,
            orphans=orphans,
            left_behind=left_behind,
            printed="" if is_well else printed,
        )

    def _end_orphans(self) -> int:
        """Count the processes that outlived the service, and end them."""
        end = time.monotonic() + GRACE
        while (running := processes_of(self.process.pid)) and time.monotonic() < end:
            time.sleep(0.02)
        for pid in running:
            os.kill(pid, signal.SIGKILL)
        return len(running)


def processes_of(session: int) -> Sequence[int]:
    """Find the running processes of a session, named by the process that led it."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, *numbers = path.read_text().rsplit(")", 1)[1].split()
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(numbers[2]) == session and state not in "ZX":
            found.append(int(path.parent.name))
    return found


def start_and_stop(role: str, cache: Path, number: int, delay: float) -> Stop:
    """Start a service and send it a signal.

    Args:
        cache: Folder of compiled controllers.
        delay: From the start to the signal [s].
    """
    with tempfile.TemporaryDirectory() as folder, RunningService(role, cache, folder) as service:
        time.sleep(delay)
        return service.stop(number)


def time_to_ready(role: str, cache: Path) -> float:
    """Measure how long a service takes to be ready [s]; arguments as above."""
    with tempfile.TemporaryDirectory() as folder, RunningService(role, cache, folder) as service:
        service.is_ready.wait()
        return time.monotonic() - service.started
