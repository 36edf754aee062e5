"""Controllers that are asked for an answer by a deadline."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.clock import Clock
from tsd_casadi.state import State
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.missed import Cause, Missed
from tsd_casadi.tick.tick import Tick


@runtime_checkable
class PunctualController(Protocol):
    """A controller that does not keep anybody waiting beyond a deadline."""

    def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
        """Ask for the torque of one state and command.

        Args:
            seconds: How long to wait at most.

        Returns:
            The tick, or why there is none. What comes later is never returned.
        """


class Stopwatch:
    """Any other controller: it cannot be interrupted, but what is late is not used."""

    def __init__(self, controller: WholeBodyController, clock: Clock) -> None:
        """Time a controller."""
        self._controller, self._clock = controller, clock

    def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
        """Compute the torque, and drop it if that took too long; see ``PunctualController``."""
        end = self._clock.now() + seconds
        try:
            tick = self._controller.tick(state, command)
        except InvalidValue as error:
            return Missed(Cause.REFUSED, str(error))
        over = self._clock.now() - end
        return Missed(Cause.LATE, f"by {1e3 * over:.3g} ms") if over > 0 else tick
