from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.bound import LARGEST_ACCELERATION, Bound, peak
from tsd_casadi.learning.iteration import Iteration

BASIS = PeriodicBasis()
AXES = ("com.x", "torso.rz")
PHASE = np.linspace(0, 2 * np.pi, 5_000)


@given(st.integers(0, 10_000), st.floats(0, 20))
def test_what_is_served_is_never_more_than_half_more_than_what_was_recorded(
    seed: int, size: float
) -> None:
    rng = np.random.default_rng(seed)
    applied, feedback, weights = rng.normal(size=(3, 2, BASIS.L))
    used = Iteration(0, applied, feedback=feedback)
    bound = Bound.of(AXES, BASIS, [used])
    served = bound.apply(size * weights, BASIS)
    # at other phases than the bound looks at, one degree apart
    recorded = np.abs(BASIS.evaluate(PHASE, applied + feedback)).max(axis=1)
    found = np.abs(BASIS.evaluate(PHASE, served)).max(axis=1)
    assert (found <= 1.5 * 1.01 * recorded).all()
    # a smaller one stays as it is, a larger one keeps its shape
    share = bound.share(size * weights, BASIS)
    np.testing.assert_allclose(served, share[:, None] * size * weights)
    assert ((share == 1) | np.isclose(peak(served, BASIS), bound.largest)).all()


def test_the_torque_limits_bound_what_is_more_and_are_named() -> None:
    used = Iteration(0, np.full((2, BASIS.L), 2.0), feedback=np.zeros((2, BASIS.L)))
    bound = Bound.of(AXES, BASIS, [used], [1.0, 50.0])
    np.testing.assert_allclose(bound.largest, [1.0, 3.0])
    assert "torque limits" in bound.reason
    assert "torque limits" not in Bound.of(AXES, BASIS, [used]).reason


def test_repetitions_that_were_not_made_say_nothing() -> None:
    untested = Iteration(1, np.full((2, BASIS.L), 5.0))
    bound = Bound.of(AXES, BASIS, [untested])
    assert bound.largest == (LARGEST_ACCELERATION["m"], LARGEST_ACCELERATION["rad"])


def test_what_is_generalised_is_bounded_by_the_largest_of_its_entries() -> None:
    bounds = [{"com.x": 1.0, "torso.rz": 9.0}, {"torso.rz": 2.0, "com.x": 3.0}]
    bound = Bound.among(AXES, bounds)
    assert bound.largest == (3.0, 9.0)
    np.testing.assert_allclose(
        peak(bound.apply(np.full((2, BASIS.L), 5.0), BASIS), BASIS), [3.0, 5.0]
    )


@pytest.mark.parametrize("size", [0.0, 1e-300])
def test_nothing_stays_nothing(size: float) -> None:
    bound = Bound((0.0, 1.0), "")
    assert not bound.apply(np.full((2, BASIS.L), size), BASIS)[0].any()
