"""Links that close without waiting for a client that does not read."""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import Any

import zenoh
from zenoh.handlers import FifoChannel

from tsd_casadi.wire.quick_close import no_waiting_closes

# of events; more of them at once wait
EVENTS = 1024


class UnhurriedLinks:
    """Lets the kernel close a session's links in the background: at each new one anew."""

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
