"""A moving squat whose controller goes away for good."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from tsd_casadi import Command, Controller, Robot, Squat, State, Tick
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.exceptions import ControllerSilent
from tsd_casadi.fallback.fallback import Fallback
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.repetition.pace import Pace
from tsd_casadi.repetition.repeat import repeat
from tsd_casadi.repetition.repetition import HOLD
from tsd_casadi.state import Vector
from tsd_casadi.tick.missed import Cause, Missed
from tsd_clients.simulator.simulator import MujocoSimulator

HELD = 2.0  # s
NEAR = 5e-3  # m


class Still:
    """A clock that goes only where somebody waits for it."""

    def __init__(self) -> None:
        self.time = 0.0

    def now(self) -> float:
        return self.time

    def sleep_until(self, moment: float) -> None:
        self.time = max(self.time, moment)


class Mortal:
    """Answers so many ticks and no more."""

    def __init__(self, controller: Controller, ticks: int) -> None:
        self.controller, self.left = controller, ticks
        self.format = controller.format

    def command(self) -> Command:
        return self.controller.command()

    def tick(self, state: State, command: Command) -> Tick:
        raise AssertionError("nobody waits here")

    def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
        self.left -= 1
        if self.left < 0:
            return Missed(Cause.NOTHING_THERE)
        return self.controller.tick(state, command)


class Path:
    """Where the true centre of mass goes in periods without an answer."""

    def __init__(self) -> None:
        self.com: list[Vector] = []
        self.velocity = 0.0

    def start(self, setting: Setting) -> None:
        pass

    def tick(self, moment: Moment) -> None:
        pass

    def missed(self, moment: Moment) -> None:
        assert moment.truth is not None
        self.com.append(moment.truth.com)

    def lap(self, lap: Lap) -> None:
        pass

    def end(self, outcome: str) -> None:
        self.outcome = outcome


def hold(
    robot: Robot,
    controller: Controller,
    squat: Squat,
    error: float,
    phase: float,
    *,
    hardware: Sequence[str] = (),
    period: float = 1e-3,
    fallback: Fallback | None = None,
) -> tuple[float, float]:
    """How far the centre of mass is from where the answers stopped: in the end, at worst [m]."""
    path = Path()
    # the first lap begins smoothly, the second one moves
    ticks = round((HOLD + (1 + phase) / squat.frequency) / period)
    with pytest.raises(ControllerSilent, match="nothing there"):
        repeat(
            MujocoSimulator(robot, error, hardware, period=period),
            Mortal(controller, ticks),
            squat,
            observers=[path],
            pace=Pace(patience=HELD, clock=Still(), fallback=fallback),
        )
    assert path.outcome == "aborted"  # it stands
    away = np.linalg.norm(np.array(path.com) - path.com[0], axis=1)
    assert len(away) == pytest.approx(HELD / period, abs=2)
    return float(away[-1]), float(away.max())


@pytest.mark.parametrize("error", [0.1, -0.1])
@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5, 0.75])
def test_hold_alone_stays_where_the_answers_stopped(
    robot: Robot, controller: Controller, error: float, phase: float
) -> None:
    assert hold(robot, controller, Squat(0.04, 0.5), error, phase)[0] <= NEAR
