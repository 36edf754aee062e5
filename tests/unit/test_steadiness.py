"""Laps that scatter are steady, laps that drift are not; those that agree are in test_laps."""

from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.scatter import scatter_of
from tsd_casadi.encoding.steadiness import (
    ABSOLUTE_TOLERANCE,
    DRIFT_LEVEL,
    LEAST_SCATTERING,
    RELATIVE_TOLERANCE,
    drifts,
    steady_from,
    tolerance,
)

BASIS = PeriodicBasis()
PHASE = np.linspace(0, 2 * np.pi, 250, endpoint=False)
# of a whole of 1 m/s^2: four times the tolerance in a single fitted lap
NOISE = 0.04 * np.sqrt(250 / BASIS.L)


def laps(means: list[float], noise: float = NOISE, seed: int = 0) -> list[Lap]:
    """Laps about some means, behind one in which the motion begins."""
    rng = np.random.default_rng(seed)
    signals = [mean + noise * rng.standard_normal((1, 250)) for mean in means]
    return [Lap(PHASE, signal) for signal in (np.full((1, 250), 9.0), *signals)]


def needed(noise: float, seed: int, most: int = 60) -> int | None:
    """Laps until some that scatter about 1 m/s^2 are steady, besides the very first."""
    whole = laps([1.0] * most, noise, seed)
    for count in range(3, most + 1):
        if steady_from(whole[:count], ["m"]) is not None:
            return count - 1
    return None


def test_noise_of_the_joints_is_no_reason_to_refuse() -> None:
    for seed in range(10):
        assert needed(NOISE / 4, seed) is not None
        assert steady_from(laps([1.0] * 12, seed=seed), ["m"], is_last_chance=True) is not None


def test_more_noise_takes_more_laps_until_their_mean_is_as_accurate() -> None:
    counts = {
        share: np.median([needed(share * NOISE, seed) or 99 for seed in range(9)])
        for share in (0.05, 0.25, 0.5)
    }
    # half the tolerance is wanted of the mean: 2 % of 1 m/s^2 take 16 laps, 1 % four
    assert counts[0.05] <= LEAST_SCATTERING
    assert LEAST_SCATTERING <= counts[0.25] <= LEAST_SCATTERING + 1
    assert 12 <= counts[0.5] <= 20


@pytest.mark.parametrize("drift", [0.02, 0.1])
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_what_drifts_is_refused_to_the_last(drift: float, noise: float) -> None:
    # noise: of a fitted lap, as a share of the drift from lap to lap
    each = noise * drift * np.sqrt(250 / BASIS.L)
    moving = laps([1 + drift * lap for lap in range(14)], each)
    assert steady_from(moving, ["m"], is_last_chance=True) is None


def test_what_settles_counts_from_where_it_has() -> None:
    settling = laps([1 + 3 * 0.3**lap for lap in range(14)], NOISE / 8)
    found = [steady_from(settling[:count], ["m"]) for count in range(3, 16)]
    first = next(each for each in found if each is not None)
    # the fourth lap is the first one within a few times the tolerance, of index 4
    assert 4 <= first <= 9


def test_laps_that_only_scatter_are_rarely_taken_for_a_drift() -> None:
    wrong = 0
    for seed in range(200):
        fitted = [BASIS.fit(PHASE, lap.feedback) for lap in laps([1.0] * 8, seed=seed)[1:]]
        wrong += drifts(fitted, scatter_of(fitted, BASIS), BASIS)
    # at DRIFT_LEVEL one in a thousand
    assert wrong <= 1 + 200 * 3 * DRIFT_LEVEL


def test_too_few_scattering_laps_tell_nothing() -> None:
    few = laps([1.0] * (LEAST_SCATTERING - 1))
    assert steady_from(few, ["m"], is_last_chance=True) is None


def test_an_axis_is_as_steady_as_those_of_its_unit() -> None:
    size = np.array([3.0, 4.0, 0.0])
    found = tolerance(size, ["m", "m", "rad"])
    np.testing.assert_allclose(found, [5 * RELATIVE_TOLERANCE] * 2 + [ABSOLUTE_TOLERANCE])


def test_what_next_to_nothing_is_added_along_need_not_repeat_by_itself() -> None:
    wave = np.ones((1, 250))
    moving = [Lap(PHASE, np.vstack([wave, (0.1 + 2e-3 * lap) * wave])) for lap in range(5)]
    assert steady_from(moving, ["m", "m"]) == 1
    assert steady_from(moving, ["m", "rad"]) is None
