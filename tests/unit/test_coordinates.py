from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi.generalization.coordinates import Coordinates
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.motions.squat import Squat

NAMES = ("amplitude", "height")
INPUTS = np.array([[0.02, -0.03], [0.04, 0.0], [0.08, 0.01]])


def test_the_learned_range_is_two_wide() -> None:
    for coordinates in Coordinates.possible(Squat.declaration(), NAMES, INPUTS):
        places = coordinates.places(INPUTS)
        np.testing.assert_allclose(places.min(axis=0), -1)
        np.testing.assert_allclose(places.max(axis=0), 1)


def test_what_cannot_be_negative_may_count_by_its_ratios() -> None:
    straight, by_ratio = Coordinates.possible(Squat.declaration(), NAMES, INPUTS)
    assert (straight.by_ratio, by_ratio.by_ratio) == (False, True)
    # 2 to 4 is as far as 4 to 8, nearly; the height stays straight
    assert by_ratio.places(INPUTS)[1, 0] == pytest.approx(0.0, abs=0.03)
    np.testing.assert_allclose(by_ratio.places(INPUTS)[:, 1], straight.places(INPUTS)[:, 1])
    np.testing.assert_allclose(straight.places(INPUTS)[1, 0], -1 / 3)


def test_zero_is_a_place_too() -> None:
    inputs = np.array([[0.0, 0.0], [0.04, 0.1], [0.08, 0.2]])
    for coordinates in Coordinates.possible(Squat.declaration(), NAMES, inputs):
        assert np.isfinite(coordinates.places(np.array([[0.0, 0.0], [0.001, 0.1]]))).all()


@pytest.mark.parametrize(
    ("declaration", "names", "inputs"),
    [
        (Squat.declaration(), ("height",), INPUTS[:, 1:]),
        (Declaration.unknown("wave"), NAMES, INPUTS),
    ],
)
def test_what_may_be_negative_counts_straight(
    declaration: Declaration, names: tuple[str, ...], inputs: np.ndarray
) -> None:
    (only,) = Coordinates.possible(declaration, names, inputs)
    assert not only.by_ratio
