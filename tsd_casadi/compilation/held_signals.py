"""Signals that wait until what must not be left behind is gone."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

# handlers that end whatever is under way; a user's own one need not
ENDING = (signal.SIG_DFL, signal.default_int_handler)


@contextmanager
def held_signals() -> Iterator[list[int]]:
    """Hold back SIGINT, SIGTERM and SIGHUP; the first one counts when the block is left.

    Without this a signal ends the process between any two instructions, and what
    it had started or written would stay behind. Signals that are ignored or that
    the user handles are left alone, and so are all of them outside the main thread,
    where Python handles none.

    Yields:
        Numbers of the signals that came. Whoever waits should look at it now and
        then and give up with any exception when there is one: another thread may
        have taken the signal, which then wakes nobody.
    """
    came: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield came
        return
    try:
        # one by one, so that each is given back whatever happens
        with (
            _held(signal.SIGINT, came),
            _held(signal.SIGTERM, came),
            _held(signal.SIGHUP, came),
        ):
            yield came
    except BaseException:
        if not came:
            raise
    if came:
        _end(came[0])


@contextmanager
def _held(number: int, came: list[int]) -> Iterator[None]:
    def note(number: int, frame: FrameType | None) -> None:
        came.append(number)

    before = signal.getsignal(number)
    if before not in ENDING:
        yield
        return
    signal.signal(number, note)
    try:
        yield
    finally:
        signal.signal(number, before)


def _end(number: int) -> None:
    """Do what the signal would have done."""
    if signal.getsignal(number) is signal.default_int_handler:
        raise KeyboardInterrupt from None
    signal.pthread_sigmask(signal.SIG_UNBLOCK, [number])
    signal.raise_signal(number)
