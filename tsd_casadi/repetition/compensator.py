"""What may change a command before a tick, and the torque after it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.motions.motion import Motion, Reference
from tsd_casadi.repetition.plant import Truth
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.missed import Missed
from tsd_casadi.tick.tick import Tick


@dataclass(frozen=True)
class Setting:
    """What a repetition is about, told to compensators and observers at its start.

    Attributes:
        robot: The robot as the controller knows it.
        controller: Local or remote.
        motion: What is done.
        axes: Names 'task.axis' of all axes of the repetition, k of them.
        learned: The first so many of them are learned, the others only move.
        index: Where the axes are in ``Tick.error`` and ``Tick.feedback``, (k,).
        period: Control period [s].
    """

    robot: Robot
    controller: WholeBodyController
    motion: Motion
    axes: tuple[str, ...]
    learned: int
    index: Vector
    period: float

    def gain(self, command: Command, name: str) -> Vector:
        """Read a gain of every axis.

        Args:
            name: 'P' or 'D'.

        Returns:
            (k,) [1/s^2] or [1/s].
        """
        return np.asarray(command.request[self._gain_places[name]])

    @cached_property
    def _gain_places(self) -> dict[str, Vector]:
        known = self.controller.format
        pairs = [axis.rpartition(".")[::2] for axis in self.axes]
        return {
            name: np.array(
                [
                    known.request.slice(f"{task}.{name}").start + known.component_index(task, axis)
                    for task, axis in pairs
                ],
                dtype=int,
            )
            for name in ("P", "D")
        }


@dataclass(slots=True)
class Moment:
    """One tick while it is being prepared and answered.

    Attributes:
        time: Since the repetition began [s].
        phase: phi [rad], not wrapped.
        lap: -1 while holding.
        state: As measured.
        reference: Of the axes, relative to the middle of the motion, (k,) each.
        feedforward: Acceleration added along the axes, (k,) [m/s^2, rad/s^2].
        command: The command. What the motion sets in it, references and
            feedforward of the axes, is written after all compensators were
            asked; before that it is the previous tick's.
        shift: Added to the position reference of the centre of mass, (3,) [m],
            world axes. The controller's error is that to the shifted reference,
            the true error of the records that to the motion's.
        shift_rate: Added to its velocity reference, (3,) [m/s].
        truth: Where somebody knows it.
        tick: The answer; only after the tick.
        tau: The torque that will be applied, (n,) [N m], cut off at the robot's
            torque limits; only after the tick.
        true_error: Of the axes, (k,) [m, rad]; NaN where nobody knows it.
        tick_time: Round trip of the tick [us]; only after the tick.
        missed: Why there is no tick, in a period that had no answer.
        offered: The learned or borrowed term in full, (k,) [m/s^2, rad/s^2].
        share: How much of it is in ``feedforward``, 0 to 1: it is phased in.
    """

    time: float
    phase: float
    lap: int
    state: State
    reference: Reference
    feedforward: Vector
    command: Command
    shift: Vector = field(default_factory=partial(np.zeros, 3))
    shift_rate: Vector = field(default_factory=partial(np.zeros, 3))
    truth: Truth | None = None
    tick: Tick | None = None
    tau: Vector = field(default_factory=partial(np.zeros, 0))
    true_error: Vector = field(default_factory=partial(np.zeros, 0))
    tick_time: float = 0.0
    missed: Missed | None = None
    offered: Vector = field(default_factory=partial(np.zeros, 0))
    share: float = 1.0


class Compensator:
    """Does nothing; the base of what does something.

    Before a tick it may change ``feedforward``, ``shift`` and ``shift_rate`` of
    the moment; after it, ``tau``. Several compensators are asked in the order of
    their list, each sees what those before it changed. A period without an answer
    has no after.

    Attributes:
        veto: Why the feedforward is no longer in use, for people; None while it is.
            What ran under a veto is recorded as run without feedforward.
        remarks: What else people should know of the repetition.
        correction: Fingerprint of the estimated centre of mass that it brings in;
            empty if it brings none. What is learned with it is another entry.
    """

    veto: str | None = None
    remarks: tuple[str, ...] = ()
    correction: str = ""

    def start(self, setting: Setting) -> None:
        """Begin: called once at the start of each repetition, before its first tick.

        Args:
            setting: What it is about.
        """

    def before(self, moment: Moment) -> None:
        """Act before each tick.

        Args:
            moment: The tick, without its answer.
        """

    def after(self, moment: Moment) -> None:
        """Act after each tick, before its torque is applied.

        Args:
            moment: The tick with its answer.
        """
