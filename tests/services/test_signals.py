"""A service ends at its first signal, whatever it is doing, and leaves nothing behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

import tsd_casadi as tsd
from tsd_casadi.exceptions import ServiceUnreachable
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_server.service_process import free_endpoint

ROOT = Path(__file__).parents[2]
SIGNALS = [signal.SIGINT, signal.SIGTERM]
# a client that is frozen may cost one second; the rest is for a loaded machine
ALLOWED = 2.0


@contextmanager
def python(*arguments: str, **options: Any) -> Iterator[subprocess.Popen[str]]:
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    with subprocess.Popen([sys.executable, *arguments], text=True, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def read_until(process: subprocess.Popen[str], word: str) -> None:
    assert process.stdout is not None
    for line in process.stdout:
        if word in line:
            return
    raise AssertionError(f"ended without {word!r}")


def end(process: subprocess.Popen[str], number: int) -> tuple[int, str]:
    """Exit code and what was said on stderr."""
    start = time.monotonic()
    process.send_signal(number)
    code = process.wait(timeout=10.0)
    assert time.monotonic() - start < ALLOWED
    errors = process.communicate()[1]
    return code, errors


def test_random_moments_under_load(controller: tsd.Controller, tmp_path: Path) -> None:
    """The benchmark's own command, in short: the fixture has the controller compiled."""
    results = tmp_path / "signals.json"
    options = ["--cycles", "12", "--load", "1", "--compiling", "0", "--json", str(results)]
    with python("-m", "benchmarks.signals", *options, cwd=ROOT) as process:
        try:
            errors = process.communicate(timeout=240)[1]
        except subprocess.TimeoutExpired:
            # it ends the service that it has running, and says what it knows
            process.send_signal(signal.SIGINT)
            errors = process.communicate(timeout=30)[1]
    assert results.is_file(), errors
    found = json.loads(results.read_text())
    assert process.returncode == 0, found["cycles"]
    assert found["summary"]["all"]["cycles"] == 12
    # by the signal itself, or told to stop
    assert found["summary"]["all"]["exit_codes"].keys() <= {"0", "-2", "-15"}


# ctypes.PyDLL keeps the GIL: no Python runs in this process for a minute
DEAF = """
import ctypes
from tsd_server.end_at_once import end_at_once
end_at_once()
print("deaf", flush=True)
ctypes.PyDLL(None).sleep(60)
"""


@pytest.mark.parametrize("number", SIGNALS)
def test_code_that_holds_the_interpreter_does_not_hold_the_signal(number: signal.Signals) -> None:
    with python("-c", DEAF) as process:
        read_until(process, "deaf")
        assert end(process, number) == (-number, "")


# only another thread can take the signal, as the kernel may decide at any time
ELSEWHERE = """
import signal, threading
from tsd_server.stop_signals import StopSignals
threading.Thread(target=threading.Event().wait, daemon=True).start()
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT, signal.SIGTERM])
with StopSignals() as signals:
    print("waiting", flush=True)
    signals.wait()
print("woken")
"""


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_that_another_thread_takes_wakes_the_main_thread(number: signal.Signals) -> None:
    with python("-c", ELSEWHERE) as process:
        read_until(process, "waiting")
        assert end(process, number) == (0, "")


# a session that never closes, as with a frozen client
STUCK = """
import threading
from tsd_server.end_at_once import end_at_once
from tsd_server.serve import end_process
from tsd_server.place import Place
from tsd_server.service import Service
from tsd_server.service_process import free_endpoint

class Stuck:
    def __init__(self, session):
        self.liveliness = session.liveliness
    def close(self):
        print("closing", flush=True)
        threading.Event().wait()

end_at_once()
service = Service("learner", "*", Place([free_endpoint()]))
service.session = Stuck(service.session)
with service:
    service.run("nothing")
end_process(0)
"""


def test_a_session_that_does_not_close_holds_nothing_up() -> None:
    with python("-c", STUCK) as process:
        read_until(process, "ready on")
        assert end(process, signal.SIGTERM) == (0, "")


@pytest.mark.parametrize("number", SIGNALS)
def test_a_second_signal_waits_for_nothing(number: signal.Signals) -> None:
    with python("-c", STUCK) as process:
        read_until(process, "ready on")
        process.send_signal(signal.SIGTERM)
        read_until(process, "closing")
        assert end(process, number) == (-number, "")


FAILING = """
import threading
from tsd_server.place import Place
from tsd_server.service import Service
from tsd_server.service_process import free_endpoint

def queries():
    raise RuntimeError("the channel broke")
    yield

service = Service("learner", "*", Place([free_endpoint()]))
service._answering._start(queries())
with service:
    service.run("nothing")
"""


def test_a_thread_that_fails_ends_the_service() -> None:
    with python("-c", FAILING) as process:
        _, errors = process.communicate(timeout=20.0)
    assert process.returncode == 1
    assert "the channel broke" in errors


def block_signals() -> None:
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)


def ignore_interrupts() -> None:
    # what a shell does for jobs in the background
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@pytest.mark.parametrize("prepare", [block_signals, ignore_interrupts])
@pytest.mark.parametrize("number", SIGNALS)
def test_what_the_parent_did_with_signals_does_not_matter(
    number: signal.Signals, prepare: Callable[[], None], tmp_path: Path
) -> None:
    arguments = ["--database", str(tmp_path / "a.sqlite"), "--listen", free_endpoint()]
    with python("-m", "tsd_server", "learner", *arguments, preexec_fn=prepare) as process:
        read_until(process, "ready on")
        assert end(process, number) == (0, "")


@pytest.mark.skipif(sys.platform != "linux", reason="looks at processes in /proc")
@pytest.mark.parametrize("number", SIGNALS)
def test_a_service_that_compiles_says_so_and_takes_its_compiler_along(
    number: signal.Signals, tmp_path: Path
) -> None:
    started = tmp_path / "started"
    os.mkfifo(started)
    compiler = tmp_path / "slow-cc"
    compiler.write_text(
        f'#!/bin/sh\n[ "$1" = --version ] && exit 0\nsleep 300 &\necho $! >{started}\nwait\n'
    )
    compiler.chmod(0o755)
    cache = tmp_path / "cache"
    environment = {**os.environ, "CC": str(compiler), "TSD_CACHE_DIR": str(cache)}
    arguments = ["-m", "tsd_server", "controller", "--listen", free_endpoint()]
    with python(*arguments, env=environment) as process:
        pid = int(started.read_text())  # blocks until the compiler runs
        code, errors = end(process, number)
    assert code == -number
    assert errors == "compiling the controller of hermes_lower: once on this machine, about 20 s\n"
    assert not Path(f"/proc/{pid}").exists() or "\nState:\tZ" in (
        Path(f"/proc/{pid}/status").read_text()
    )
    assert list(cache.iterdir()) == []


def patient_learner(endpoint: str) -> RemoteLearner:
    """A client of a service that cannot say when it is ready."""
    for _ in range(10):
        with suppress(ServiceUnreachable):
            return RemoteLearner([endpoint])
    raise AssertionError("no learner came up")


def test_nobody_who_reads_is_no_reason_to_stop(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    endpoint = free_endpoint()
    arguments = ["--database", str(tmp_path / "a.sqlite"), "--listen", endpoint]
    with python("-m", "tsd_server", "learner", *arguments, stdout=writer) as process:
        os.close(writer)
        with patient_learner(endpoint) as learner:
            assert learner.database().entries == []
        assert end(process, signal.SIGTERM) == (0, "")
