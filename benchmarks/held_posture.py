"""A moving squat whose controller goes away for good: where the hold alone leaves it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tsd_casadi.controller.controller import Controller
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.exceptions import ControllerSilent
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.repetition.pace import Pace
from tsd_casadi.repetition.repeat import repeat
from tsd_casadi.repetition.repetition import HOLD
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.missed import Cause, Missed
from tsd_casadi.tick.tick import Tick
from tsd_clients.simulator.simulator import MujocoSimulator

HELD = 2.0  # s


@dataclass(frozen=True)
class Held:
    """How far the centre of mass was from where the answers stopped [m].

    Attributes:
        end: After two seconds; infinite if the robot fell.
        worst: In between.
    """

    end: float
    worst: float


class Unhurried:
    """A clock that goes only where somebody waits for it."""

    def __init__(self) -> None:
        """Begin at zero."""
        self.time = 0.0

    def now(self) -> float:
        """Tell the time [s]."""
        return self.time

    def sleep_until(self, moment: float) -> None:
        """Go there [s]."""
        self.time = max(self.time, moment)


class Mortal:
    """Answers so many ticks and no more."""

    def __init__(self, controller: Controller, ticks: int) -> None:
        """Stand in for a controller."""
        self._controller, self._left = controller, ticks
        self.format, self.command = controller.format, controller.command

    def tick(self, state: State, command: Command) -> Tick:
        """Compute a torque whoever lives."""
        return self._controller.tick(state, command)

    def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
        """Answer, or not."""
        self._left -= 1
        return Missed(Cause.NOTHING_THERE) if self._left < 0 else self.tick(state, command)


class _Path:
    def __init__(self) -> None:
        self.com: list[Vector] = []
        self.outcome = ""

    def start(self, setting: Setting) -> None: ...

    def tick(self, moment: Moment) -> None: ...

    def missed(self, moment: Moment) -> None:
        assert moment.truth is not None
        self.com.append(moment.truth.com)

    def lap(self, lap: Lap) -> None: ...

    def end(self, outcome: str) -> None:
        self.outcome = outcome


def hold(
    robot: Robot,
    controller: Controller,
    motion: Motion,
    error: float,
    share: float,
    *,
    hardware: Sequence[str] = (),
    period: float = 1e-3,
) -> Held:
    """Let the controller go away in the second lap, which the first one brought into motion.

    Args:
        error: Of the masses.
        share: Of the lap that is over then.
        period: Control period [s].
    """
    path = _Path()
    ticks = round((HOLD + (1 + share) / motion.frequency) / period)
    try:
        repeat(
            MujocoSimulator(robot, error, hardware, period=period),
            Mortal(controller, ticks),
            motion,
            observers=[path],
            pace=Pace(patience=HELD, clock=Unhurried()),
        )
    except ControllerSilent:
        away = np.linalg.norm(np.array(path.com) - path.com[0], axis=1)
        return Held(float(away[-1]), float(away.max()))
    return Held(np.inf, np.inf)  # it fell before
