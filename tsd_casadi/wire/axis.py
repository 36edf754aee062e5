"""Learned axes and how well they were tracked, on the network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Annotated, Literal

from pydantic import Field

from tsd_casadi.document import Document, Finite, Name
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.axis_error import AxisError, unit_of_axis

Unit = Literal["m", "rad"]
NotNegative = Annotated[Finite, Field(ge=0)]


class AxisMessage(Document):
    """An axis.

    Attributes:
        name: 'task.axis', world axes.
        unit: 'm' of a translation, 'rad' of a rotation.
    """

    name: Name
    unit: Unit


Axes = Annotated[list[AxisMessage], Field(min_length=1, max_length=50)]


def axis_messages(axes: Sequence[str]) -> list[AxisMessage]:
    """Describe axes."""
    return [_axis_message(axis) for axis in axes]


@lru_cache(1_000)
def _axis_message(axis: str) -> AxisMessage:
    return AxisMessage.model_validate({"name": axis, "unit": unit_of_axis(axis)})


def plain_axes(axes: Sequence[AxisMessage]) -> tuple[str, ...]:
    """Check units and names of axes, and keep the names.

    Raises:
        MalformedMessage: If one is there twice or has another unit.
    """
    names = tuple(axis.name for axis in axes)
    for axis in axes:
        if axis.unit != unit_of_axis(axis.name):
            raise MalformedMessage(
                f"axis {axis.name} in '{axis.unit}'", f"'{unit_of_axis(axis.name)}'"
            )
        if names.count(axis.name) > 1:
            raise MalformedMessage(f"axis {axis.name} twice", "each axis once")
    return names


class AxisErrorMessage(Document):
    """Measures of one axis over whole steady laps.

    Attributes:
        rms: RMS error as the controller sees it [unit].
        peak: Largest absolute error [unit].
        ac_rms: RMS error without its mean [unit].
        mean_abs_feedback: Mean absolute feedback [unit/s^2].
        true_rms: RMS error of the robot itself, where somebody knows it [unit].
        laps: How many laps it was measured in; the learner fills it.
        deviation: Standard deviation of the RMS error of a single lap [unit]; the
            learner fills it.
        scatter: Standard deviation of the feedback from lap to lap, RMS over the phase
            [unit/s^2]: what does not repeat; the learner fills it.
        unit: Of the axis.
    """

    rms: NotNegative
    peak: NotNegative | None = None
    ac_rms: NotNegative | None = None
    mean_abs_feedback: NotNegative | None = None
    true_rms: NotNegative | None = None
    laps: Annotated[int, Field(ge=1)] | None = None
    deviation: NotNegative | None = None
    scatter: NotNegative | None = None
    unit: Unit


def error_messages(errors: Mapping[str, AxisError]) -> dict[str, AxisErrorMessage]:
    """Describe errors by axis."""
    return {
        axis: AxisErrorMessage.model_validate({**error.plain(), "unit": unit_of_axis(axis)})
        for axis, error in errors.items()
    }


def plain_errors(
    errors: Mapping[str, AxisErrorMessage], axes: Sequence[str]
) -> dict[str, AxisError]:
    """Check units of errors and put them in the order of the axes.

    Raises:
        MalformedMessage: If there is not one for each axis, in its unit.
    """
    if set(errors) != set(axes):
        raise MalformedMessage(
            f"errors of {', '.join(errors) or 'no axis'}", f"one of each of {', '.join(axes)}"
        )
    for axis in axes:
        if errors[axis].unit != unit_of_axis(axis):
            raise MalformedMessage(
                f"errors of {axis} in '{errors[axis].unit}'", f"'{unit_of_axis(axis)}'"
            )
    return {axis: AxisError(**errors[axis].model_dump(exclude={"unit"})) for axis in axes}
