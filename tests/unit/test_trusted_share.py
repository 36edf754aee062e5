from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi.encoding.laps import FittedLaps
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.scatter import Scatter
from tsd_casadi.learning.trusted_share import trusted_share

BASIS = PeriodicBasis()
# of a mean lap: 1 in its signal, 2 in its weights
SCATTER = Scatter(4, np.array([2.0]), np.array([4.0]))


def share(feedback: float, before: float | None, scatter: Scatter | None = SCATTER) -> float:
    weights = np.full((1, BASIS.L), feedback)
    known = None if before is None else np.full((1, BASIS.L), before)
    return float(trusted_share(FittedLaps(weights, scatter=scatter), known, BASIS)[0])


def test_what_is_far_above_noise_is_learned() -> None:
    assert share(100.0, before=2.0) == pytest.approx(1, abs=1e-3)


def test_at_the_floor_of_the_noise_repetitions_are_averaged() -> None:
    # the second one counts half, the third one a third, ...
    before = 2.0
    for count in range(2, 6):
        assert share(0.5, before) == pytest.approx(1 / count)
        before = 2.0 * np.sqrt(1 / count)


def test_all_is_learned_where_nothing_is_known_of_noise_or_weights() -> None:
    assert share(0.1, before=None) == 1.0
    assert share(0.1, before=2.0, scatter=None) == 1.0
    still = Scatter(2, np.zeros(1), np.zeros(1))
    assert share(0.1, before=0.0, scatter=still) == 1.0


def test_each_axis_for_itself() -> None:
    fitted = FittedLaps(
        np.repeat([[100.0], [0.5]], BASIS.L, axis=1),
        scatter=Scatter(4, np.array([2.0, 2.0]), np.array([4.0, 4.0])),
    )
    found = trusted_share(fitted, np.full((2, BASIS.L), 2.0), BASIS)
    np.testing.assert_allclose(found, [1.0, 0.5], atol=1e-3)
