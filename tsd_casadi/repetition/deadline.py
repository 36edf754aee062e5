"""Controllers that are asked for an answer by a deadline."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue
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


class Uninterrupted:
    """Any other controller: it takes the time that it takes, whoever asked looks at the clock."""

    def __init__(self, controller: WholeBodyController) -> None:
        """Ask a controller."""
        self._controller = controller

    def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
        """Compute the torque, perhaps too late; see ``PunctualController``."""
        try:
            return self._controller.tick(state, command)
        except InvalidValue as error:
            return Missed(Cause.REFUSED, str(error))
