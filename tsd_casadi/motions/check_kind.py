"""Whether a motion's class says what it has to, and its derivatives are true."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.motion import Motion, declared_parameters
from tsd_casadi.motions.parameter import RESERVED, Parameter
from tsd_casadi.state import Vector

NAME = re.compile(r"[a-z][a-z0-9_]*")
PHASES = (0.0, 0.7, 1.9, 3.3, 4.6, 5.8)  # rad, none special but the first
STEP = 1e-4  # rad, of the differences
# of the largest value, of what differences of that step leave of a smooth motion
TOLERANCE = 1e-4


def check_kind(kind: type[Motion]) -> None:
    """Refuse a class that cannot be learned as a motion.

    Raises:
        InvalidValue: If a member is missing, it is no frozen dataclass, a parameter
            has a reserved name, or the offset is not periodic or has other
            derivatives than differences say.
    """
    who = kind.__name__
    missing = sorted(getattr(kind, "__abstractmethods__", ()))
    name = getattr(kind, "name", None)
    if not isinstance(name, str):
        missing = ["name", *missing]
    if missing:
        raise InvalidValue(who, f"without {' and '.join(missing)}", "all members of a Motion")
    if not NAME.fullmatch(str(name)):
        raise InvalidValue(f"name of {who}", f"'{name}'", "small letters, digits and _")
    parameters = getattr(kind, "__dataclass_params__", None)
    if "__dataclass_fields__" not in vars(kind) or parameters is None or not parameters.frozen:
        raise InvalidValue(who, "no frozen dataclass", "@dataclass(frozen=True) above the class")
    declared = {item.name: item for item in declared_parameters(kind)}
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        if field.name not in declared:
            raise InvalidValue(
                f"{who}.{field.name}", "no parameter", 'a value from parameter("m", ...)'
            )
        if field.name in RESERVED or not NAME.fullmatch(field.name):
            raise InvalidValue(
                f"parameter of {who}",
                f"'{field.name}'",
                f"small letters, digits and _, and none of {', '.join(RESERVED)}",
            )
    if "frequency" not in declared:
        raise InvalidValue(
            who, "without frequency", 'frequency: float = parameter("Hz", default=0.25)'
        )
    check_offset(kind(**{name: _sample(item) for name, item in declared.items()}))


def check_offset(motion: Motion) -> None:
    """Refuse offsets that are not periodic, or whose derivatives are not their own.

    Raises:
        InvalidValue: It names the derivative, the phase and both values.
    """
    who = type(motion).__name__
    try:
        with np.errstate(all="ignore"):  # what is not finite is told below
            lap = [motion.offset(phase) for phase in np.linspace(0, 2 * np.pi, 64)]
    except Exception as error:  # a user's code may raise anything
        found = f"raising {type(error).__name__}: {error}"
        raise InvalidValue(f"offset of {who}", found, "no error at any phase") from error
    for each in lap:
        sizes = {np.shape(values) for values in (each.x, each.by_phase, each.by_phase_twice)}
        if len(sizes) > 1 or not sizes.copy().pop():
            raise InvalidValue(
                f"offset of {who}", f"of shapes {sizes}", "three arrays of one number an axis"
            )
    x, first, second = (
        np.array([getattr(each, name) for each in lap])
        for name in ("x", "by_phase", "by_phase_twice")
    )
    for name, values in (("x", x), ("by_phase", first), ("by_phase_twice", second)):
        if not np.isfinite(values).all():
            raise InvalidValue(f"{name} of {who}", "not finite somewhere in a lap", "numbers")
        if not np.allclose(values[0], values[-1], rtol=0, atol=1e-6 * (1e-3 + np.abs(x).max())):
            raise InvalidValue(f"{name} of {who}", "another after a lap", "the same every 2 pi")
    largest = max(float(np.abs(x).max()), 1e-6)
    for phase in PHASES:
        before, now, after = (motion.offset(phase + step) for step in (-STEP, 0.0, STEP))
        _compare(who, "by_phase", phase, now.by_phase, (after.x - before.x) / (2 * STEP), largest)
        twice = (after.by_phase - before.by_phase) / (2 * STEP)
        _compare(who, "by_phase_twice", phase, now.by_phase_twice, twice, largest)


def _compare(
    who: str, name: str, phase: float, said: Vector, differences: Vector, largest: float
) -> None:
    allowed = TOLERANCE * (largest + np.abs(differences).max())
    wrong = np.abs(np.asarray(said) - differences) > allowed
    if wrong.any():
        axis = int(np.argmax(wrong))
        raise InvalidValue(
            f"{name} of {who} at phase {phase:g} rad",
            f"{said[axis]:.6g} on axis {axis}",
            f"{differences[axis]:.6g}, which differences give: the exact derivative by the phase",
        )


def _sample(item: Parameter) -> float:
    """Choose a value that is neither special nor out of range."""
    if item.default is not None and item.default != 0.0:
        return item.default
    value = 0.1 if item.usual is None else item.usual
    inside = min(max(value, item.low), item.high)
    return inside if math.isfinite(inside) else 0.1
