from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.encoding.laps import Lap, join_laps
from tsd_casadi.encoding.steadiness import (
    ABSOLUTE_TOLERANCE,
    RELATIVE_TOLERANCE,
    first_steady_lap,
)

PHASE = np.linspace(0, 2 * np.pi, 200, endpoint=False)
# mean 0 and standard deviation 1 on PHASE
WAVE = np.sqrt(2) * np.sin(PHASE)


def lap(mean: float = 0.0, deviation: float = 0.0) -> Lap:
    return Lap(PHASE, (mean + deviation * WAVE)[None, :])


def steady_from(laps: list[Lap]) -> int | None:
    """Index of the first steady lap among some that follow the very first one."""
    k = laps[0].feedback.shape[0] if laps else 1
    beginning = Lap(PHASE, np.full((k, PHASE.size), 1e6))
    found = first_steady_lap([beginning, *laps], ["m"] * k)
    return None if found is None else found - 1


def test_tolerances_are_the_documented_ones() -> None:
    assert (RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE) == (0.01, 1e-4)


@pytest.mark.parametrize(
    ("one", "other", "steady"),
    [
        # mean, 1 % is more than 1e-4
        (lap(mean=1.0), lap(mean=1.0099), True),
        (lap(mean=1.0), lap(mean=0.9901), True),
        (lap(mean=1.0), lap(mean=1.0101), False),
        (lap(mean=-1.0), lap(mean=-1.0099), True),
        (lap(mean=-1.0), lap(mean=-1.0101), False),
        # mean, 1e-4 is more than 1 %
        (lap(mean=1e-3), lap(mean=1e-3 + 0.99e-4), True),
        (lap(mean=1e-3), lap(mean=1e-3 + 1.01e-4), False),
        (lap(mean=0.0), lap(mean=0.99e-4), True),
        (lap(mean=5e-5), lap(mean=-4e-5), True),
        (lap(mean=6e-5), lap(mean=-6e-5), False),
        # AC RMS
        (lap(deviation=1.0), lap(deviation=1.0099), True),
        (lap(deviation=1.0), lap(deviation=1.0101), False),
        (lap(deviation=1e-3), lap(deviation=1e-3 + 0.99e-4), True),
        (lap(deviation=1e-3), lap(deviation=1e-3 + 1.01e-4), False),
        # one of the two is not enough
        (lap(1.0, 1.0), lap(1.001, 1.5), False),
        (lap(1.0, 1.0), lap(1.5, 1.001), False),
        # a large mean does not excuse the AC part
        (lap(100.0, 0.1), lap(100.5, 0.102), False),
    ],
)
def test_two_laps_agree_to_one_percent_or_1e_4(one: Lap, other: Lap, steady: bool) -> None:
    assert steady_from([one, other]) == (0 if steady else None)


def test_every_axis_has_to_agree() -> None:
    one = Lap(PHASE, np.vstack([WAVE, WAVE]))
    other = Lap(PHASE, np.vstack([WAVE, 1.5 * WAVE]))
    assert steady_from([one, one]) == 0
    assert steady_from([one, other]) is None


@pytest.mark.parametrize("count", [0, 1])
def test_one_lap_alone_is_never_steady(count: int) -> None:
    assert steady_from([lap(1.0)] * count) is None


@pytest.mark.parametrize(
    ("means", "expected"),
    [
        ([1, 1], 0),
        ([1, 1, 1, 1], 0),
        ([3, 1, 1], 1),
        ([3, 2, 1, 1], 2),
        # agreed once, then not: only the end counts
        ([1, 1, 2, 2], 2),
        ([1, 1, 2], None),
        ([1, 1, 1, 1, 2], None),
        # agrees only with a lap before the last
        ([1, 2, 1], None),
        ([4, 3, 2, 1], None),
    ],
)
def test_steady_is_a_suffix_of_laps_that_agree_with_the_next(
    means: list[float], expected: int | None
) -> None:
    assert steady_from([lap(mean) for mean in means]) == expected


def test_slow_drift_is_steady_though_first_and_last_differ() -> None:
    # consecutive laps are compared, not the ends
    laps = [lap(1.005**index) for index in range(10)]
    assert steady_from(laps) == 0


def test_growing_oscillation_is_never_steady() -> None:
    assert steady_from([lap(0.0, 1.1**index) for index in range(10)]) is None


@given(st.lists(st.sampled_from([1.0, 1.005, 2.0, 5.0]), max_size=8))
def test_steady_laps_are_the_longest_agreeing_suffix(means: list[float]) -> None:
    first = steady_from([lap(mean) for mean in means])
    changes = [
        index
        for index in range(1, len(means))
        if abs(means[index - 1] - means[index]) >= 0.01 * means[index - 1]
    ]
    longest = max(changes, default=0)
    assert first == (longest if longest < len(means) - 1 else None)


def test_the_very_first_lap_never_counts() -> None:
    assert first_steady_lap([lap(1.0), lap(1.0)], ["m"]) is None
    assert first_steady_lap([lap(1.0), lap(1.0), lap(1.0)], ["m"]) == 1


@pytest.mark.parametrize(("fed_forward", "steady"), [(1.0, True), (0.1, False)])
def test_what_was_fed_forward_counts_for_the_scale(fed_forward: float, steady: bool) -> None:
    # what is left of the feedback changes by much of itself, by little of the whole
    laps = [
        Lap(PHASE, np.full((1, 200), left), feedforward=np.full((1, 200), fed_forward))
        for left in (2e-3, 7e-3)
    ]
    assert (steady_from(laps) is not None) == steady


def test_the_mean_of_a_motion_to_and_fro_may_be_noise() -> None:
    one, other = (Lap(PHASE, (noise + WAVE)[None, :]) for noise in (1e-3, -1e-3))
    assert steady_from([one, other]) == 0


def test_join_keeps_order_and_whole_laps() -> None:
    one = Lap(np.arange(5.0), np.arange(10.0).reshape(2, 5))
    other = Lap(np.arange(5.0, 8.0), np.arange(6.0).reshape(2, 3))
    joined = join_laps([one, other])
    np.testing.assert_array_equal(joined.phase, np.arange(8.0))
    np.testing.assert_array_equal(joined.feedback, np.hstack([one.feedback, other.feedback]))


def test_positions_are_joined_in_order() -> None:
    laps = [Lap(PHASE, WAVE[None, :], i * WAVE[None, :], WAVE[None, :] + i) for i in (1, 2)]
    joined = join_laps(laps)
    assert joined.error is not None
    assert joined.reference is not None
    np.testing.assert_array_equal(joined.error, np.hstack([WAVE, 2 * WAVE])[None, :])
    np.testing.assert_array_equal(joined.reference, np.hstack([WAVE + 1, WAVE + 2])[None, :])


def test_positions_are_unknown_if_one_lap_has_none() -> None:
    whole = Lap(PHASE, WAVE[None, :], WAVE[None, :], WAVE[None, :])
    for other in (lap(), Lap(PHASE, WAVE[None, :], WAVE[None, :])):
        joined = join_laps([whole, other])
        assert joined.error is None
        assert joined.reference is None
