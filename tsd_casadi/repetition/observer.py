"""What watches a repetition without touching it."""

from __future__ import annotations

from collections import deque
from typing import Any, Protocol

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.repetition.compensator import Moment, Setting


class Observer(Protocol):
    """Told of everything that happens, in order, in the thread of the loop.

    A tick waits for it: whoever has more to do than to take a note does it in a
    thread or process of its own. An error of an observer ends the repetition.
    Every observer that was told of the start is told of the end, also then; the
    one that was told of the start first is told of the end last.
    """

    def start(self, setting: Setting) -> None:
        """Learn that a repetition begins."""

    def tick(self, moment: Moment) -> None:
        """Learn that a tick was answered and its torque is being applied."""

    def missed(self, moment: Moment) -> None:
        """Learn that a period had no answer and the fallback's torque is being applied.

        Only in a repetition against the clock; ``moment.missed`` tells why.
        """

    def lap(self, lap: Lap) -> None:
        """Learn that a whole lap is over."""

    def end(self, outcome: str) -> None:
        """Learn that the repetition is over: 'steady', 'never steady', 'fell' or 'aborted'."""


class Glimpses:
    """The newest ticks for somebody who may be slow: drops the oldest and counts.

    Attributes:
        dropped: How many ticks nobody took in time.
    """

    def __init__(self, most: int = 1000) -> None:
        """Keep at most so many ticks."""
        self.dropped = 0
        self._kept: deque[dict[str, Any]] = deque(maxlen=most)
        self._setting: Setting | None = None

    def start(self, setting: Setting) -> None:
        """Learn that a repetition begins; what is left of the one before stays."""
        self._setting = setting

    def tick(self, moment: Moment) -> None:
        """Note what a picture needs."""
        assert self._setting is not None and moment.tick is not None
        if len(self._kept) == self._kept.maxlen:
            self.dropped += 1
        self._kept.append(
            {
                "time": moment.time,
                "phase": moment.phase,
                "lap": moment.lap,
                "q": moment.state.q,
                "error": moment.tick.error[self._setting.index],
                "feedback": moment.tick.feedback[self._setting.index],
                "feedforward": moment.feedforward,
                "tau": moment.tau,
            }
        )

    def missed(self, moment: Moment) -> None:
        """Note nothing: a picture waits for the next tick."""

    def lap(self, lap: Lap) -> None:
        """Note nothing."""

    def end(self, outcome: str) -> None:
        """Note nothing."""

    def take(self) -> list[dict[str, Any]]:
        """Hand over what came since the last time, the oldest first."""
        return [self._kept.popleft() for _ in range(len(self._kept))]
