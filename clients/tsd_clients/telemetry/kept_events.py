"""The events that a run's story is told of."""

from __future__ import annotations

import json

from tsd_casadi.wire.run_story import join_story

# of one repetition's laps; a viewer draws no more
MOST_LAPS = 200
# of all repetitions; some kilobytes each
MOST_ITERATIONS = 1000


class KeptEvents:
    """Keeps the newest event of each kind, the laps since the last beginning, every iteration.

    Attributes:
        number: Of the newest event; 0 before the first.
        repetition: That it is in.
        is_over: Whether the run said that it is over.
    """

    def __init__(self) -> None:
        """Keep nothing yet."""
        self.number, self.repetition, self.is_over = 0, 0, False
        self._kept: dict[str, dict[int, bytes]] = {}

    def keep(self, event: bytes) -> None:
        """Keep an event."""
        plain = json.loads(event)
        kind, self.number, self.repetition = plain["event"], plain["number"], plain["repetition"]
        self.is_over = kind == "over"
        if kind == "began":
            # they were of the repetition before
            for gone in ("lap", "ended", "measured"):
                self._kept.pop(gone, None)
        of_kind = self._kept.setdefault(kind, {})
        of_kind[self.number] = event
        most = {"lap": MOST_LAPS, "iteration": MOST_ITERATIONS}.get(kind, 1)
        while len(of_kind) > most:
            del of_kind[next(iter(of_kind))]

    def story(self) -> bytes:
        """Tell the story."""
        events = {number: event for kind in self._kept.values() for number, event in kind.items()}
        return join_story([events[number] for number in sorted(events)])
