from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.steadiness import ABSOLUTE_TOLERANCE
from tsd_casadi.exceptions import OutsideTrainedRange
from tsd_casadi.generalization.weight_regression import WeightRegression
from tsd_casadi.motions.squat import Squat

BASIS = PeriodicBasis()
NAMES = ("amplitude", "frequency")
# not on a grid, so that none has a partner
PLACES = np.array(
    [
        (0.02, 0.2),
        (0.08, 0.22),
        (0.03, 0.6),
        (0.075, 0.55),
        (0.05, 0.4),
        (0.035, 0.33),
        (0.06, 0.3),
        (0.055, 0.58),
    ]
)
ASKED = {"amplitude": 0.05, "frequency": 0.35}


def learned(place: np.ndarray) -> np.ndarray:
    """Inertia, damping and friction along two axes, about an offset that all share."""
    speed = 2 * np.pi * place[0] * place[1]
    inertia = 0.1 * place[0] * (2 * np.pi * place[1]) ** 2 * np.sin(BASIS.centers)
    friction = 0.3 * np.tanh(np.cos(BASIS.centers) * speed / 0.05)
    return np.stack([-0.7 + inertia + friction, 0.05 + 0.1 * inertia])


def regression(
    places: np.ndarray, weights: list[np.ndarray], deviations: list[np.ndarray | None] | None = None
) -> WeightRegression:
    return WeightRegression(Squat.declaration(), NAMES, places, weights, BASIS, deviations)


def error(weights: np.ndarray) -> float:
    off = weights - learned(np.array([ASKED["amplitude"], ASKED["frequency"]]))
    return float(np.sqrt(np.mean(off[0] ** 2)))


@pytest.mark.parametrize("count", [6, 8])
@pytest.mark.parametrize("factor", [1.1, -1.0])
def test_an_entry_a_micrometre_beside_another_does_no_harm(count: int, factor: float) -> None:
    places, weights = PLACES[:count], [learned(place) for place in PLACES[:count]]
    alone = regression(places, weights)
    beside = places[4] + (1e-6, 0.0)
    both = regression(np.vstack([places, beside]), [*weights, factor * weights[4]])
    assert alone.disagreeing == {}
    assert list(both.disagreeing) == [count]
    assert both.disagreeing[count] > 4
    mean, _ = both.predict(ASKED)
    assert (mean[0] < 0).all() == (alone.predict(ASKED)[0][0] < 0).all()
    assert error(mean) < error(alone.predict(ASKED)[0]) + 2e-3
    assert np.abs(mean).max() < 1.2 * np.abs(np.array(weights)).max()


def test_which_of_two_is_wrong_does_not_depend_on_their_order() -> None:
    weights = [learned(place) for place in PLACES]
    places = np.vstack([PLACES[4] + (1e-6, 0.0), PLACES])
    assert list(regression(places, [1.1 * weights[4], *weights]).disagreeing) == [0]


def test_an_entry_that_is_known_to_be_uncertain_does_not_disagree() -> None:
    weights = [learned(place) for place in PLACES]
    places = np.vstack([PLACES, PLACES[4] + (1e-6, 0.0)])
    wrong = [*weights, weights[4] + 0.1]
    known: list[np.ndarray | None] = [*[None] * len(PLACES), np.full((2, BASIS.L), 0.3)]
    assert list(regression(places, wrong).disagreeing) == [len(PLACES)]
    certain, uncertain = regression(PLACES, weights), regression(places, wrong, known)
    assert uncertain.disagreeing == {}
    assert error(uncertain.predict(ASKED)[0]) < error(certain.predict(ASKED)[0]) + 5e-3


def test_three_entries_cannot_tell_who_is_wrong() -> None:
    weights = [learned(place) for place in PLACES[:4]]
    weights[0] = -weights[0]
    assert regression(PLACES[:4], weights).disagreeing == {}


def test_most_of_the_entries_are_kept() -> None:
    rng = np.random.default_rng(0)
    noise = [learned(place) + rng.normal(size=(2, BASIS.L)) for place in PLACES]
    assert len(regression(PLACES, noise).disagreeing) <= len(PLACES) // 4


@pytest.mark.parametrize("size", [1e-9, 0.5 * ABSOLUTE_TOLERANCE])
def test_what_no_lap_tells_apart_is_no_contradiction(size: float) -> None:
    # along the second axis nothing is needed, and rounding is all that there is
    weights = [learned(place) * ((1.0,), (0.0,)) for place in PLACES]
    weights[0][1] = size
    assert regression(PLACES, weights).disagreeing == {}


def test_what_laps_tell_apart_is_one() -> None:
    weights = [learned(place) * ((1.0,), (0.0,)) for place in PLACES]
    weights[4][1] = 50 * ABSOLUTE_TOLERANCE
    assert list(regression(PLACES, weights).disagreeing) == [4]


def test_rounding_along_one_axis_hides_no_wrong_entry_along_another() -> None:
    weights = [learned(place) * ((1.0,), (0.0,)) for place in PLACES]
    for index in (0, 2, 5):
        weights[index][1] = 1e-9 * (index + 1)
    places = np.vstack([PLACES, PLACES[4] + (1e-6, 0.0)])
    assert list(regression(places, [*weights, -weights[4]]).disagreeing) == [len(PLACES)]


def test_what_was_left_out_does_not_widen_the_learned_range() -> None:
    weights = [learned(place) for place in PLACES]
    far = np.array([0.16, 0.4])
    found = regression(np.vstack([PLACES, far]), [*weights, -40 * learned(far)])
    assert list(found.disagreeing) == [len(PLACES)]
    found.predict({"amplitude": 0.08, "frequency": 0.4})
    with pytest.raises(OutsideTrainedRange, match=r"0\.02 to 0\.08 m"):
        found.predict({"amplitude": 0.12, "frequency": 0.4})
    found.predict({"amplitude": 0.12, "frequency": 0.4}, extrapolate=True)
