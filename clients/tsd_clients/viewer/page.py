"""The page: a server, what is polled for news, and the panels that show it."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from typing import Protocol

import viser

from tsd_clients.viewer.panel import Panel

# faster than the eye tells single pictures apart, and slow enough for a browser without a
# graphics card [1/s]
RATE = 25.0


class Feed(Protocol):
    """Where news comes from."""

    def poll(self, now: float) -> None:
        """Take in what is new, without waiting for anything.

        Args:
            now: Monotonic time [s].
        """

    def close(self) -> None:
        """Let go of what is open."""


class Page:
    """Panels of one server, kept up to date by one thread: the caller's."""

    def __init__(
        self, server: viser.ViserServer, feeds: Sequence[Feed], panels: Sequence[Panel]
    ) -> None:
        """Build the panels.

        Args:
            feeds: Polled before the panels are updated, in this order.
            panels: Those without a title above the tabs, the others one tab each.
        """
        self._server, self._feeds, self._panels = server, feeds, panels
        self._stopped = threading.Event()
        for panel in panels:
            if not panel.title:
                panel.build(server)
        tabs = server.gui.add_tab_group()
        for panel in panels:
            if panel.title:
                with tabs.add_tab(panel.title):
                    panel.build(server)

    def run(self) -> None:
        """Keep the page up to date until it is stopped."""
        try:
            while not self._stopped.is_set():
                began = time.monotonic()
                self.update(began)
                self._stopped.wait(max(0.0, began + 1.0 / RATE - time.monotonic()))
        finally:
            for feed in self._feeds:
                feed.close()
            self._server.stop()

    def update(self, now: float) -> None:
        """Take in what is new and, if somebody looks, show it.

        Args:
            now: Monotonic time [s].
        """
        for feed in self._feeds:
            feed.poll(now)
        if self._server.get_clients():
            # what belongs together arrives together
            with self._server.atomic():
                for panel in self._panels:
                    panel.update(now)

    def stop(self) -> None:
        """End ``run``, from any thread."""
        self._stopped.set()
