from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.repetition.evidence import BOUND, CLEAR, NEGLIGIBLE, Evidence, Seen

lengths = st.lists(st.floats(-1, 1), min_size=3, max_size=3)


def seen_of(without: np.ndarray, moved: np.ndarray) -> Seen:
    products = (moved @ moved, moved @ without, without @ without)
    return Seen.of(*(float(each) for each in products))


@given(lengths, lengths)
def test_it_is_the_difference_of_the_squared_errors_where_it_is_not_bounded(
    without: list[float], moved: list[float]
) -> None:
    e, u = np.array(without), np.array(moved)
    seen = seen_of(e, u)
    assert seen.with_it == pytest.approx(float((e - u) @ (e - u)), abs=1e-12)
    assert abs(seen.surplus) <= BOUND * seen.effect
    if abs(float(e @ u) - 0.5 * seen.effect) < BOUND * seen.effect:
        assert 2 * seen.surplus == pytest.approx(seen.without_it - seen.with_it, abs=1e-12)


def test_a_push_of_any_size_counts_no_more_than_its_time() -> None:
    fits, evidence = np.array([0.01]), Evidence(100)
    for tick in range(100):
        # a little less than a third of the time against 1/2 for the rest
        evidence.add(seen_of(fits - (1e3 if tick < 33 else 0.0), fits))
    assert evidence.helps()
    evidence.add(seen_of(fits - 1e3, fits))  # the oldest goes, which was one as well
    assert evidence.helps()
    for _ in range(32):
        evidence.add(seen_of(fits - 1e3, fits))
    assert evidence.helps()
    evidence.add(seen_of(fits - 1e3, fits))
    assert evidence.harms()


@pytest.mark.parametrize(
    ("needed", "harms", "clearly"), [(0.36, True, True), (0.37, True, False), (0.51, False, False)]
)
def test_less_than_half_of_it_needed_is_harm(needed: float, harms: bool, clearly: bool) -> None:
    evidence = Evidence(50)
    for phase in np.linspace(0, 6, 50):
        u = np.array([0.02, 0.01 * np.sin(phase)])
        evidence.add(seen_of(needed * u, u))
    assert evidence.harms() == harms
    assert evidence.harms(CLEAR) == clearly
    assert evidence.helps() != harms
    with_it, without_it = evidence.errors
    assert with_it / without_it == pytest.approx((1 - needed) / needed)
    # three times the squared error, about
    assert ((1 - needed) / needed > np.sqrt(3)) == clearly


@pytest.mark.parametrize(("effect", "judged"), [(0.99, False), (1.01, True)])
def test_an_effect_that_is_negligible_is_not_judged(effect: float, judged: bool) -> None:
    evidence = Evidence(10)
    for _ in range(10):
        evidence.add(seen_of(np.zeros(1), np.array([effect * NEGLIGIBLE])))
    assert evidence.harms() == judged


def test_it_is_of_the_newest_ticks_and_can_be_forgotten() -> None:
    good, bad = seen_of(np.ones(1), np.ones(1)), seen_of(-np.ones(1), np.ones(1))
    evidence = Evidence(10)
    for number in range(25):
        assert evidence.is_complete == (number >= 10)
        evidence.add(bad if number < 15 else good)
    assert evidence.helps()
    assert evidence.errors == pytest.approx((0.0, 1.0))
    evidence.forget()
    assert not evidence.is_complete
    assert not evidence.helps()
    assert not evidence.harms()
    assert evidence.errors == (0.0, 0.0)
