"""What may change a command before a tick, and the torque after it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.motions.motion import Reference
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.tick import Tick


@dataclass(frozen=True)
class Setting:
    """What a repetition is about, told to each compensator at its start.

    Attributes:
        robot: The robot as the controller knows it.
        controller: Local or remote.
        task: Name of the learned task.
        component: Index of the learned axis among the task's axes.
        axis: Index of the learned axis among all tasks' axes, as in
            ``Tick.error``.
        dt: Time step [s].
    """

    robot: Robot
    controller: WholeBodyController
    task: str
    component: int
    axis: int
    dt: float


@dataclass(slots=True)
class Moment:
    """One tick while it is being prepared and answered.

    Attributes:
        time: Of the repetition [s].
        phase: phi [rad], not wrapped.
        lap: -1 while holding.
        state: As measured.
        reference: Along the learned axis, relative to the middle of the motion.
        feedforward: Acceleration added along the learned axis [m/s^2].
        command: The command. What the motion sets in it, reference and
            feedforward of the learned task, is written after all compensators
            were asked; before that it is the previous tick's.
        shift: Added to the task's position reference, (3,) [m], world axes. The
            controller's error is that to the shifted reference, the true error
            of the records that to the motion's.
        shift_rate: Added to its velocity reference, (3,) [m/s].
        tick: The answer; only after the tick.
        tau: The torque that will be applied, (n,) [N m], cut off at the robot's
            torque limits; only after the tick.
    """

    time: float
    phase: float
    lap: int
    state: State
    reference: Reference
    feedforward: float
    command: Command
    shift: Vector = field(default_factory=partial(np.zeros, 3))
    shift_rate: Vector = field(default_factory=partial(np.zeros, 3))
    tick: Tick | None = None
    tau: Vector = field(default_factory=partial(np.zeros, 0))


class Compensator:
    """Does nothing; the base of what does something.

    Before a tick it may change ``feedforward``, ``shift`` and ``shift_rate`` of
    the moment; after it, ``tau``. Several compensators are asked in the order of
    their list, each sees what those before it changed.
    """

    def start(self, setting: Setting) -> None:
        """Prepare for a repetition; called once, before its first tick."""

    def before(self, moment: Moment) -> None:
        """Change what is asked; called before each tick."""

    def after(self, moment: Moment) -> None:
        """Change what is applied; called after each tick, before its torque is."""
