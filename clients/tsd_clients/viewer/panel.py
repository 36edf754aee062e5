"""A part of the page."""

from __future__ import annotations

import abc

import viser


class Panel(abc.ABC):
    """One part of the page: controls and pictures under a title, or things in the 3D view.

    Everything happens in the page's one thread: a panel that waits keeps the page waiting,
    so whatever takes longer than some milliseconds is asked for elsewhere and looked at in
    ``update``. What a user clicks is called by threads of the server: note it there, act on
    it in ``update``.

    Attributes:
        title: Of its tab; empty for what stands above the tabs.
    """

    title: str = ""

    @abc.abstractmethod
    def build(self, server: viser.ViserServer) -> None:
        """Add what is there from the beginning; called once, within the panel's tab."""

    @abc.abstractmethod
    def update(self, now: float) -> None:
        """Show what is new; called some 25 times a second while somebody looks.

        Args:
            now: Monotonic time [s].
        """
