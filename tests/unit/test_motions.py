"""Every motion that is shipped, found as the command line finds it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Robot
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.catalogue import find_motion, shipped_motions
from tsd_casadi.motions.check_kind import check_kind
from tsd_casadi.motions.motion import Motion, declared_parameters

KINDS = {name: kind for name, kind in shipped_motions().items() if name != "file"}
EVERY = pytest.mark.parametrize("name", KINDS)


def example_of(kind: type[Motion], frequency: float = 0.25) -> Motion:
    """A motion with nothing special about its parameters."""
    values = {
        item.name: 0.03 if item.default is None else item.default + 0.01
        for item in declared_parameters(kind)
    }
    return kind(**{**values, "frequency": frequency})


def test_the_shipped_motions_are_found_by_looking() -> None:
    assert list(shipped_motions()) == sorted(shipped_motions())
    assert {"squat", "sway", "lean", "circle", "twist", "reach", "file"} <= set(shipped_motions())
    for name, kind in shipped_motions().items():
        # a motion is one file of its name
        assert kind.__module__ == f"tsd_casadi.motions.{name}"
        assert find_motion(name) is kind or name == "file"


@EVERY
def test_each_says_what_it_is(name: str) -> None:
    kind = KINDS[name]
    check_kind(kind)
    declaration = kind.declaration()
    assert (declaration.motion, declaration.version) == (name, kind.version)
    for item in declaration.parameters:
        assert item.unit
        assert item.meaning
    sizes = [item for item in declaration.parameters if item.extent]
    # 'tsd simulate NAME' without any option does something
    assert sizes
    assert all(item.default is not None or item.usual is not None for item in sizes)


@EVERY
@given(elapsed=st.floats(0.0, 40.0), frequency=st.floats(0.05, 1.0))
def test_derivatives_agree_with_differences(name: str, elapsed: float, frequency: float) -> None:
    motion = example_of(KINDS[name], frequency)
    omega, step = 2 * math.pi * frequency, 1e-4
    # at the very start only forward times exist
    middle = elapsed + step
    before, now, after = (motion.reference(middle + shift) for shift in (-step, 0.0, step))
    rate, size = omega / (2 * step), 0.03
    np.testing.assert_allclose(now.xd, (after.x - before.x) * rate, atol=1e-6 * size * omega)
    np.testing.assert_allclose(now.xdd, (after.xd - before.xd) * rate, atol=2e-3 * size * omega**2)


@EVERY
def test_each_starts_in_its_middle_at_rest_without_a_jerk(name: str) -> None:
    start = example_of(KINDS[name]).reference(0.0)
    for values in (start.x, start.xd, start.xdd):
        assert not values.any()


@EVERY
def test_no_jump_where_the_start_ends(name: str) -> None:
    motion = example_of(KINDS[name])
    for boundary in (0.0, math.pi):
        one, other = (motion.reference(boundary + each) for each in (-1e-9, 1e-9))
        for values in ("x", "xd", "xdd"):
            np.testing.assert_allclose(getattr(one, values), getattr(other, values), atol=1e-8)


@EVERY
def test_axes_and_offsets_belong_together(name: str, robot: Robot) -> None:
    motion = example_of(KINDS[name])
    try:
        axes = motion.axes(robot)
    except InvalidValue as error:  # it lacks the task, and is told so
        assert robot.name in str(error)
        return
    assert len(set(axes)) == len(axes) == len(motion.offset(0.3).x)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("sqaut", "did you mean 'squat'"),
        ("jump", "'circle', .*'squat'.*my_motion.py:Bounce"),
        ("my_motion.py", "the class as well, as my_motion.py:Bounce"),
        ("nowhere.py:Bounce", "'nowhere.py', which cannot be read"),
        ("nowhere.csv", "'nowhere.csv', which cannot be read"),
    ],
)
def test_what_is_no_motion_is_told_with_those_there_are(name: str, words: str) -> None:
    with pytest.raises(InvalidValue, match=words):
        find_motion(name)
