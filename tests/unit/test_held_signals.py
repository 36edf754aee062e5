"""A compilation that is interrupted leaves neither a compiler nor a folder behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from tsd_casadi.compilation.held_signals import held_signals

PROGRAM = """
import signal, sys, threading
from tsd_casadi.compilation.code_cache import compile_cached
threading.Thread(target=threading.Event().wait, daemon=True).start()
PREPARE
try:
    compile_cached({"answer.c": "int answer(void) { return 42; }"})
except KeyboardInterrupt:
    print("interrupted")
"""
DEFAULT = "signal.signal(signal.SIGINT, signal.SIG_DFL)"
# only another thread can take the signals then, which does not wake this one
ELSEWHERE = "signal.pthread_sigmask(signal.SIG_BLOCK, [2, 15])"


class Compilation:
    """A process that compiles, with a compiler that has started a program and never ends."""

    def __init__(self, folder: Path, prepare: str) -> None:
        self.cache = folder / "cache"
        self._pid = folder / "pid"
        os.mkfifo(self._pid)
        wrapper = folder / "slow-cc"
        wrapper.write_text(
            f'#!/bin/sh\n[ "$1" = --version ] && exit 0\nsleep 300 &\necho $! >{self._pid}\nwait\n'
        )
        wrapper.chmod(0o755)
        environment = {**os.environ, "CC": str(wrapper), "TSD_CACHE_DIR": str(self.cache)}
        self.process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM.replace("PREPARE", prepare)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )
        # blocks until the compiler runs
        self.started = int(self._pid.read_text())

    def leftovers(self) -> list[Path]:
        return list(self.cache.iterdir())


def is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(sys.platform != "linux", reason="looks at processes in /proc")
@pytest.mark.parametrize("prepare", ["", DEFAULT, ELSEWHERE], ids=["python", "default", "thread"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_nothing_is_left_of_an_interrupted_compilation(
    tmp_path: Path, number: signal.Signals, prepare: str
) -> None:
    compilation = Compilation(tmp_path, prepare)
    compilation.process.send_signal(number)
    output, errors = compilation.process.communicate(timeout=10.0)
    assert not is_running(compilation.started)
    assert compilation.leftovers() == []
    assert errors == ""
    if number == signal.SIGINT and prepare != DEFAULT:
        assert (output, compilation.process.returncode) == ("interrupted\n", 0)
    else:
        assert (output, compilation.process.returncode) == ("", -number)


def test_a_signal_counts_when_the_block_is_left() -> None:
    seen = []
    with pytest.raises(KeyboardInterrupt), held_signals() as came:
        os.kill(os.getpid(), signal.SIGINT)
        seen = list(came)
    assert seen == [signal.SIGINT]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_signal_goes_before_an_error() -> None:
    with pytest.raises(KeyboardInterrupt) as caught, held_signals():
        os.kill(os.getpid(), signal.SIGINT)
        raise OSError("disk full")
    assert caught.value.__suppress_context__


def test_without_a_signal_an_error_passes() -> None:
    with pytest.raises(OSError, match="disk full"), held_signals():
        raise OSError("disk full")


@pytest.fixture
def handle_sigterm() -> object:
    before = signal.getsignal(signal.SIGTERM)
    yield lambda handler: signal.signal(signal.SIGTERM, handler)
    signal.signal(signal.SIGTERM, before)


def test_a_users_own_handler_is_left_alone(handle_sigterm: Callable[[object], object]) -> None:
    seen: list[int] = []
    handle_sigterm(lambda number, frame: seen.append(number))
    with held_signals() as came:
        os.kill(os.getpid(), signal.SIGTERM)
        assert seen == [signal.SIGTERM]
    assert came == []


def test_an_ignored_signal_stays_ignored(handle_sigterm: Callable[[object], object]) -> None:
    handle_sigterm(signal.SIG_IGN)
    with held_signals() as came:
        os.kill(os.getpid(), signal.SIGTERM)
    assert came == []
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN


def test_another_thread_holds_nothing() -> None:
    before = signal.getsignal(signal.SIGINT)
    inside: list[object] = []

    def work() -> None:
        with held_signals():
            inside.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert inside == [before]
