"""A log: every tick of a repetition as arrays, and what is known of the repetition."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.repetition.measure_axis import measure_axis
from tsd_casadi.state import Vector
from tsd_casadi.wire.run_outline import RunOutline


@dataclass(frozen=True)
class Log:
    """What is read from the file of a log.

    Attributes:
        fields: One array per quantity, first axis the tick; see ``LOG_FIELDS``.
        axes: The axes of the repetition.
        robot: Name of the robot; empty if the file does not tell, as a .csv.
        model: Fingerprint of its files; empty if the file does not tell.
        infeasible_request: State and command of the first tick without a solution;
            None if there was none or the file does not tell.
        outline: Motion, parameters, period, robot file, torque limits and the meaning of
            the controller's numbers; None if the file does not tell.
        summary: ``Run.summary`` of the repetition; of one that was killed nothing but
            'aborted', and empty if the file does not tell.
        more: Arrays as in ``fields`` that only some files have; see ``MORE_FIELDS``.
    """

    fields: dict[str, Vector]
    axes: tuple[str, ...]
    robot: str = ""
    model: str = ""
    infeasible_request: Vector | None = None
    outline: RunOutline | None = None
    summary: dict[str, Any] = field(default_factory=dict)
    more: dict[str, Vector] = field(default_factory=dict)

    @property
    def ticks(self) -> int:
        """Number of control ticks."""
        return len(self.fields["time"])

    @property
    def learned(self) -> tuple[str, ...]:
        """The axes that are learned; none where the file does not tell."""
        return () if self.outline is None else self.axes[: self.outline.learned]

    @property
    def laps_run(self) -> int:
        """Number of laps that the log has, the last one maybe in part."""
        laps = self.fields["lap"]
        return len(np.unique(laps[laps >= 0]))

    @property
    def errors(self) -> dict[str, AxisError]:
        """The measures of every axis, from the ticks; NaN where nothing was measured."""
        measured = self.fields["measured"]
        columns = [self.fields[name][measured] for name in ("error", "true_error", "feedback")]
        return {
            axis: measure_axis(*(values[:, place] for values in columns))
            for place, axis in enumerate(self.axes)
        }
