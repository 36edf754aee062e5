"""Connections whose close does not wait for an end that does not read."""

from __future__ import annotations

import os
import socket
import stat
import struct
import sys
from contextlib import suppress

# struct linger: off, so that the kernel sends what is left after the close
NO_LINGER = struct.pack("ii", 0, 0)


def no_waiting_closes(locator: str) -> None:
    """Take the option back on every connection of this process to one of its addresses.

    Zenoh asks for closes that wait up to 10 s for the other end to take what was
    sent, and does so in the thread that receives from everybody: one frozen client,
    or one whose cable was pulled, then stops all others. There is no setting for it.

    Args:
        locator: This process's end of the link, 'tcp/127.0.0.1:7447' for instance.
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
