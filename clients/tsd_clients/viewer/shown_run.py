"""A run on the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from tsd_casadi.state import Vector
from tsd_clients.viewer.ticks import Ticks


@dataclass(frozen=True)
class RunLabel:
    """What is known of a run before its first tick.

    Attributes:
        key: Tells it from all others, for as long as the page lives.
        robot: Name of the robot.
        robot_file: What ``load_robot`` takes for it.
        model: Fingerprint of the robot's files; empty if nobody knows.
        motion: What is done.
        parameters: How, in words; may be empty.
        axes: 'task.axis' of all axes of the repetition.
        learned: The first so many of them are learned.
        joints: In the order of tau.
        contacts: In the order of the wrenches.
        all_axes: (task, axis) in the order of all errors.
        limit_rows: Names of the rows that can be bounded.
        torque_limits: By joint, (n,) [N m].
    """

    key: str
    robot: str
    robot_file: str
    model: str
    motion: str
    parameters: str
    axes: tuple[str, ...]
    learned: int
    joints: tuple[str, ...]
    contacts: tuple[str, ...]
    all_axes: tuple[tuple[str, str], ...]
    limit_rows: tuple[str, ...]
    torque_limits: Vector

    @property
    def title(self) -> str:
        """Name it for people."""
        return f"{self.robot}: {self.motion}"


def words_of(parameters: Mapping[str, float]) -> str:
    """Write a motion's parameters for people: 'amplitude 0.03, frequency 0.4'."""
    return ", ".join(f"{name} {value:.4g}" for name, value in parameters.items())


class ShownRun(Protocol):
    """A run whose newest ticks can be shown."""

    @property
    def label(self) -> RunLabel:
        """What it is."""

    @property
    def state(self) -> str:
        """How it is, in a few words: 'running', 'over: steady'."""

    @property
    def ticks(self) -> Ticks:
        """The ticks of the last seconds, the newest last; maybe none yet."""


class Runs(Protocol):
    """What is shown now."""

    @property
    def shown(self) -> tuple[ShownRun, ...]:
        """Runs, those that began first in front."""
