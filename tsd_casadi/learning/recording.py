"""What one repetition leaves behind for learning."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tsd_casadi.encoding.laps import Lap, join_positions
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.feedback_loop import require_loop
from tsd_casadi.state import Matrix

Rule = Literal["guarded", "plain", "stable"]


@dataclass(frozen=True)
class TaskKey:
    """What tells one database entry from another.

    Attributes:
        robot: Name of the robot.
        task: Name of the motion, for instance 'squat'.
        axes: Names 'task.axis' of the learned axes.
        parameters: Task parameters, SI units, rounded to 1e-6.
    """

    robot: str
    task: str
    axes: tuple[str, ...]
    parameters: tuple[tuple[str, float], ...]

    @classmethod
    def of(
        cls, robot: str, task: str, axes: tuple[str, ...], parameters: dict[str, float]
    ) -> TaskKey:
        """Make a key, rounding and sorting the parameters."""
        rounded = tuple(sorted((name, round(value, 6)) for name, value in parameters.items()))
        return cls(robot, task, axes, rounded)

    def describe(self) -> str:
        """For people: 'squat amplitude=0.03 frequency=0.25 on my_robot'."""
        values = " ".join(f"{name}={value:g}" for name, value in self.parameters)
        return f"{self.task} {values} on {self.robot}"


@dataclass(frozen=True)
class Context:
    """Under what circumstances a recording was made.

    Attributes:
        formulation: Layout hash of the controller, hexadecimal.
        model: Fingerprint of the controller's robot description.
        gains: Gains of the learned axes, by field name.
        version: Version of this software.
    """

    formulation: str
    model: str
    gains: dict[str, Any]
    version: str


@dataclass(frozen=True)
class Recording:
    """The steady laps of one repetition.

    Attributes:
        key: The entry it belongs to.
        basis: The basis of the applied weights.
        applied: Weights of the feedforward in use, (k, L) [m/s^2].
        laps: Whole steady laps with the feedback term.
        errors: Measures of the repetition; 'rms_error_m' decides what is worse.
        context: Circumstances.
        rule: 'plain' is the paper's sum; 'guarded' the same, never serving what
            proved worse; 'stable' is guarded, and filters by the estimated
            response of the loop.
        update: False to note the errors only, without learning from the laps.
        restart: Forget the entry first.
    """

    key: TaskKey
    basis: PeriodicBasis
    applied: Matrix
    laps: list[Lap]
    errors: dict[str, float]
    context: Context
    rule: Rule = "guarded"
    update: bool = True
    restart: bool = False

    def __post_init__(self) -> None:
        """Refuse numbers that nothing can be learned from.

        Raises:
            InvalidValue: If weights, laps or errors are not finite, laps are
                missing, or the rule is 'stable' and positions, frequency or
                gains are not known.
        """
        if not np.isfinite(self.errors.get("rms_error_m", np.nan)):
            raise InvalidValue("rms_error_m", self.errors.get("rms_error_m"), "a number of metres")
        if not self.laps:
            raise InvalidValue("laps", "none", "at least one whole steady lap")
        if self.rule == "stable":
            self._check_stable()
        for name, values in (
            ("the applied weights", self.applied),
            *(
                (f"lap {index}", values)
                for index, lap in enumerate(self.laps)
                for values in (lap.phase, lap.feedback, lap.error, lap.reference)
                if values is not None
            ),
        ):
            if not np.isfinite(values).all():
                raise InvalidValue(name, "not finite", "finite numbers")

    def _check_stable(self) -> None:
        """Refuse what the rule 'stable' cannot filter."""
        if join_positions(self.laps) is None:
            raise InvalidValue(
                "laps", "without error and reference", "both for the rule 'stable', or another rule"
            )
        require_loop(self.key.axes, dict(self.key.parameters), self.context.gains)
