from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.constraints.joint_position import LARGEST_MARGIN, MARGIN, position_bounds

LOW, HIGH = -1.0, 1.0
TICKS = 300
PREDICTIONS = ("semi-implicit", "constant acceleration")


def compiled() -> ca.Function:
    q, v, b, T, active = (ca.SX.sym(name) for name in ("q", "v", "b", "T", "active"))
    bounds = position_bounds(q, v, LOW, HIGH, b, T, active)
    return ca.Function("bounds", [q, v, b, T, active], [bounds.lower, bounds.upper])


BOUNDS = compiled()


def bounds_of(q: float, v: float, b: float, T: float) -> tuple[float, float]:
    lower, upper = BOUNDS(q, v, b, T, 1.0)
    return float(lower), float(upper)


def step(q: float, v: float, a: float, T: float, prediction: str) -> tuple[float, float, float]:
    """Position and velocity a period later, and the farthest position on the way."""
    after = v + T * a
    if prediction == "semi-implicit":
        return q + T * after, after, q + T * after
    there = q + T * (v + after) / 2
    turns = v > 0 > after
    return there, after, q - v * v / (2 * a) if turns else max(q, there)


@pytest.mark.parametrize("prediction", PREDICTIONS)
@given(
    b=st.floats(5, 200),
    T=st.floats(2e-4, 5e-3),
    way=st.floats(0, 0.3),
    speed=st.floats(0, 1),
    pushes=st.integers(0, 2**32 - 1),
)
def test_a_joint_that_is_pushed_stops_before_its_limit_by_braking(
    prediction: str, b: float, T: float, way: float, speed: float, pushes: int
) -> None:
    margin = MARGIN * b * T**2
    q, v = HIGH - margin - way, speed * np.sqrt(2 * b * way)
    v = min(v, 2 * way / (T + np.sqrt(T**2 + 2 * way / b)))
    rng = np.random.default_rng(pushes)
    for _ in range(TICKS):
        _, upper = bounds_of(q, v, b, T)
        assert upper >= -b * (1 + 1e-6) - 1e-6  # never more than it counts on
        a = min(upper, 10 * b)
        if rng.random() < 0.1:
            a = min(a, rng.uniform(-b, b))
        q, v, farthest = step(q, v, a, T, prediction)
        assert farthest <= HIGH + 1e-12


@given(q=st.floats(-1.2, 1.2), v=st.floats(-5, 5), b=st.floats(5, 200))
def test_the_lower_limit_is_the_upper_one_in_a_mirror(q: float, v: float, b: float) -> None:
    lower, upper = bounds_of(q, v, b, 1e-3)
    mirrored = bounds_of(-q, -v, b, 1e-3)
    assert (lower, upper) == pytest.approx((-mirrored[1], -mirrored[0]))


@given(q=st.floats(1.0, 1.5), v=st.floats(-2, 2))
def test_beyond_a_limit_it_comes_back_at_no_more_than_the_braking(q: float, v: float) -> None:
    _, upper = bounds_of(q, v, 50.0, 1e-3)
    after = v + 1e-3 * upper
    assert after <= 0
    assert after >= min(v, 0.0) - 50.0 * 1e-3 - 1e-9


def test_where_it_is_pushed_it_settles_at_the_margin() -> None:
    for prediction in PREDICTIONS:
        q, v, a = 0.9, 0.0, 0.0
        for _ in range(500):
            a = min(bounds_of(q, v, 50.0, 1e-3)[1], 50.0)
            q, v, _ = step(q, v, a, 1e-3, prediction)
        # what went past the margin in turning round comes back within a second
        assert HIGH - q == pytest.approx(MARGIN * 50.0 * 1e-6, abs=1e-6)
        assert abs(v) < 1e-5
        assert abs(a) < 1e-3


def test_a_long_period_leaves_most_of_the_range() -> None:
    margin = LARGEST_MARGIN * (HIGH - LOW)
    assert margin < MARGIN * 50.0 * 0.1**2
    # at rest at the margin nothing may move on, a little before it something may
    assert bounds_of(HIGH - margin, 0.0, 50.0, 0.1)[1] == pytest.approx(0.0, abs=1e-9)
    assert bounds_of(HIGH - 1.01 * margin, 0.0, 50.0, 0.1)[1] > 0


def test_switched_off_there_is_no_bound() -> None:
    lower, upper = BOUNDS(2.0, 5.0, 50.0, 1e-3, 0.0)
    assert (float(lower), float(upper)) == (-1e30, 1e30)


def test_no_braking_at_all_lets_nothing_move() -> None:
    lower, upper = bounds_of(0.0, 0.0, 0.0, 1e-3)
    assert lower == pytest.approx(0.0, abs=2.0)
    assert upper == pytest.approx(0.0, abs=2.0)
