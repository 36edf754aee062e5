"""Pieces of work: functions with plain arguments, and what is kept of them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.exceptions import SimulationError
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_casadi.version import __version__
from tsd_experiments.harness.duration import Span
from tsd_experiments.harness.outcome import Outcome


@dataclass(frozen=True)
class Job:
    """One piece of work.

    Attributes:
        name: Name of its files.
        function: At the top of a module, so that worker processes find it;
            called with robot, controller and the arguments.
        arguments: Plain data.
        cost: Estimated seconds, for the order of work and the bar.
        over_network: Ask both services over Zenoh; such jobs are done one
            after another, since controller and simulator keep two cores busy.
    """

    name: str
    function: Callable[..., Outcome]
    arguments: dict[str, Any] = field(default_factory=dict)
    cost: float = 10.0
    over_network: bool = False

    @property
    def function_name(self) -> str:
        """Where the function stands: 'module:name'."""
        return f"{self.function.__module__}:{self.function.__qualname__}"

    def fingerprint(self, robot: Robot) -> str:
        """Hash what the stored result must have been made from.

        The program itself counts by its version only.
        """
        scenes = [path.read_text() for path in sorted(robot.path.parent.glob("*.xml"))]
        content = [
            self.function_name,
            self.arguments,
            self.over_network,
            __version__,
            robot.fingerprint,
            mujoco.__version__,
            scenes,
        ]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Result:
    """A finished job.

    Attributes:
        rows: Plain data, one per run.
        arrays: Traces and weights by name.
        span: When it was done, begin and end [s] since 1970.
    """

    rows: list[dict[str, Any]]
    arrays: dict[str, Vector]
    span: Span

    def row(self, label: str) -> dict[str, Any]:
        """Give the row of a label.

        Args:
            label: Unique in the result.

        Raises:
            KeyError: If there is none.
        """
        for row in self.rows:
            if row["label"] == label:
                return row
        raise KeyError(label)

    def last_iteration(self) -> str:
        """Give the label of the last iteration that was run.

        Raises:
            SimulationError: If not even the first one was.
        """
        labels = [row["label"] for row in self.rows if row["label"].startswith("iteration")]
        if not labels:
            raise SimulationError(f"nothing was learned: {self.rows[-1].get('stopped')}")
        return str(labels[-1])

    def errors(self, name: str = "rms_error_m") -> Vector:
        """List one measure of every run that has it, in order.

        Args:
            name: Of the measure; its unit is at the end of the name.
        """
        return np.array([row[name] for row in self.rows if row.get(name) is not None])

    def weights(self, label: str) -> list[float]:
        """Give the weights that a run used, (L,) [m/s^2]."""
        return [float(value) for value in self.arrays[f"{label}/weights"][0]]
