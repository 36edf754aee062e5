"""Links that close without waiting for a client that does not read."""

from __future__ import annotations

import os
import socket
import stat
import struct
import sys
import threading
from contextlib import suppress
from typing import Any

import zenoh
from zenoh.handlers import FifoChannel

# struct linger: off, so that the kernel sends what is left after the close
NO_LINGER = struct.pack("ii", 0, 0)
# of events; more of them at once wait
EVENTS = 1024


class UnhurriedLinks:
    """Lets the kernel close a session's links in the background.

    Zenoh asks for closes that wait up to 10 s for the other end to take what was
    sent, and does so in the thread that receives from everybody: one frozen client,
    or one whose cable was pulled, then stops the service for all. There is no setting
    for it, so the option is taken back at each new link.
    """

    def __init__(self, session: Any) -> None:
        """Watch the links of a session from now on; they must be undeclared by closing it."""
        self._listener = session.info.declare_link_events_listener(
            FifoChannel(EVENTS), history=True
        )
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        with suppress(zenoh.ZError):
            for event in self._listener:  # ends when the session is closed
                if event.kind == zenoh.SampleKind.PUT:
                    no_waiting_closes(event.link.src)


def no_waiting_closes(locator: str) -> None:
    """Take the option back on every connection of this process to one of its addresses.

    Args:
        locator: The service's end of the link, 'tcp/127.0.0.1:7447' for instance.
    """
    if sys.platform != "linux":
        return  # no list of what is open
    port = locator.rpartition(":")[2].partition("?")[0]
    for name in os.listdir("/proc/self/fd"):
        descriptor = int(name)
        with suppress(OSError):  # closed meanwhile
            if not stat.S_ISSOCK(os.fstat(descriptor).st_mode):
                continue
            borrowed = socket.socket(fileno=os.dup(descriptor))
            with borrowed:
                if borrowed.family in (socket.AF_INET, socket.AF_INET6) and (
                    str(borrowed.getsockname()[1]) == port
                ):
                    borrowed.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, NO_LINGER)
