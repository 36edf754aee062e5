from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tsd_casadi.repetition.torque_blend import LARGEST_STEP, TorqueBlend

LIMIT = np.array([10.0, 200.0, 0.5])
SHARES = arrays(float, 3, elements=st.floats(-1.0, 1.0))
PERIODS = st.lists(st.tuples(SHARES, st.booleans()), min_size=1, max_size=60)


@given(periods=PERIODS)
def test_torques_step_no_further_than_the_bound_around_every_gap(
    periods: list[tuple[np.ndarray, bool]],
) -> None:
    blend = TorqueBlend(LIMIT)
    last, near_gap = None, False
    for share, answered in periods:
        wanted = share * LIMIT
        given_torque = blend.follow(wanted, answered=answered)
        near_gap = near_gap or not answered
        assert (np.abs(given_torque) <= LIMIT).all()
        if last is not None and near_gap:
            step = np.abs(given_torque - last) / LIMIT
            assert step.max() <= LARGEST_STEP * (1 + 1e-9)
        if answered and np.array_equal(given_torque, wanted):
            near_gap = False  # arrived
        last = given_torque


@given(wanted=st.lists(SHARES, min_size=1, max_size=20))
def test_answers_without_a_gap_pass_as_they_are(wanted: list[np.ndarray]) -> None:
    blend = TorqueBlend(LIMIT)
    for share in wanted:
        np.testing.assert_array_equal(blend.follow(share * LIMIT, answered=True), share * LIMIT)


@given(held=SHARES, answer=SHARES)
def test_an_answer_is_reached_exactly_within_forty_periods(
    held: np.ndarray, answer: np.ndarray
) -> None:
    blend = TorqueBlend(LIMIT)
    blend.follow(held * LIMIT, answered=False)
    for _ in range(round(2 / LARGEST_STEP)):
        reached = blend.follow(answer * LIMIT, answered=True)
    np.testing.assert_allclose(reached, answer * LIMIT, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(blend.follow(answer * LIMIT, answered=True), answer * LIMIT)


def test_a_step_of_the_bound_is_one_period_and_more_is_two() -> None:
    for factor, arrives in ((1.0, True), (1.001, False)):
        blend = TorqueBlend(LIMIT)
        blend.follow(np.zeros(3), answered=False)
        wanted = factor * LARGEST_STEP * LIMIT
        reached = blend.follow(wanted, answered=True)
        assert np.allclose(reached, wanted, rtol=1e-9, atol=0) == arrives
