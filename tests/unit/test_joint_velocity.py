from __future__ import annotations

import casadi as ca
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.constraints.joint_velocity import velocity_bounds


def bounds_of(v: float, limit: float, active: float = 1.0) -> tuple[float, float]:
    numbers = (ca.SX(value) for value in (v, limit, 50.0, 1e-3, active))
    found = velocity_bounds(*numbers)
    return float(found.lower), float(found.upper)


@given(v=st.floats(-5, 5), limit=st.floats(5, 10))
def test_the_next_velocity_is_inside(v: float, limit: float) -> None:
    lower, upper = bounds_of(v, limit)
    assert abs(v + 1e-3 * upper - limit) < 1e-12
    assert abs(v + 1e-3 * lower + limit) < 1e-12


@given(excess=st.floats(0.1, 5))
def test_a_joint_that_is_faster_is_braked(excess: float) -> None:
    assert bounds_of(5.0 + excess, 5.0)[1] == -50.0
    assert bounds_of(-5.0 - excess, 5.0)[0] == 50.0


def test_switched_off_there_is_no_bound() -> None:
    assert bounds_of(9.0, 5.0, 0.0) == (-1e30, 1e30)
