"""A service as a child process that never outlives its parent."""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from queue import Empty, Queue
from tempfile import TemporaryDirectory

from tsd_casadi.exceptions import ServiceNotReady
from tsd_server.end_at_once import STOPPING

PR_SET_PDEATHSIG = 1


class ServiceProcess:
    """A service started as 'python -m tsd_server ROLE ...', ready when the constructor returns.

    Attributes:
        process: The process.
        output: Lines it has printed.
    """

    def __init__(
        self,
        arguments: Sequence[str],
        patience: float = 120.0,
        *,
        run_directory: Path | None = None,
    ) -> None:
        """Start the process and wait for its 'ready' line.

        Args:
            arguments: Role and options, as of ``python -m tsd_server``.
            patience: How long to wait [s]; the first start compiles.
            run_directory: Where it says that it runs. By default in a folder of its
                own: a service that a program starts for itself is nobody else's, and
                does not keep the user's own from running.

        Raises:
            ServiceNotReady: If it ends or does not get ready in time; the message is
                what it printed.
        """
        self.output: list[str] = []
        self._own = None if run_directory is not None else TemporaryDirectory(prefix="tsd-run-")
        folder = str(run_directory) if self._own is None else self._own.name
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tsd_server", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            preexec_fn=_before_python,
            env={**os.environ, "TSD_RUN_DIR": folder},
        )
        self._lines: Queue[str | None] = Queue()
        threading.Thread(target=self._read, daemon=True).start()
        try:
            self._wait_until_ready(patience)
        except BaseException:
            self.stop()
            raise

    def __enter__(self) -> ServiceProcess:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the process."""
        self.stop()

    def stop(self) -> int:
        """Ask the process to end, and make it end.

        Returns:
            Its exit code.
        """
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            try:
                self.process.wait(timeout=5.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
        code = self.process.wait()
        if self._own is not None:
            self._own.cleanup()
        return code

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as lines:
            for line in lines:
                self.output.append(line.rstrip())
                self._lines.put(line)
        self._lines.put(None)

    def _wait_until_ready(self, patience: float) -> None:
        while True:
            try:
                line = self._lines.get(timeout=patience)
            except Empty:
                raise ServiceNotReady(f"the service was not ready after {patience:g} s") from None
            if line is None:
                printed = "\n".join(self.output) or "nothing"
                raise ServiceNotReady(
                    f"the service ended before it was ready; it printed: {printed}"
                )
            if " ready on " in line:
                return


def free_endpoint() -> str:
    """Find a loopback endpoint with a port that is free now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def _before_python() -> None:
    # Ctrl-C reaches the whole terminal: the interpreter must not print a traceback before
    # the service's first line, which lets signals through again
    signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    if sys.platform == "linux":
        # the kernel tells the child when its parent is gone, even by SIGKILL
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
