from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.comparison import WORSE_LEVEL, is_worse
from tsd_casadi.learning.iteration import Iteration

MADE = Circumstances({"P": [50.0], "D": [14.0]})


def an_iteration(laps: list[float]) -> Iteration:
    """An iteration with these RMS errors in its laps [m]."""
    deviation = float(np.std(laps, ddof=1)) if len(laps) > 1 else None
    error = AxisError(float(np.mean(laps)), laps=len(laps), deviation=deviation)
    return Iteration(1, np.zeros((1, 3)), errors={"com.z": error}, circumstances=MADE)


def test_what_differs_by_less_than_its_noise_is_not_worse() -> None:
    one, other = an_iteration([1.0e-4, 1.3e-4, 1.1e-4]), an_iteration([1.2e-4, 1.5e-4, 1.1e-4])
    assert not is_worse(other, one)
    assert not is_worse(one, other)


def test_what_differs_by_far_more_is() -> None:
    one, other = an_iteration([1.0e-4, 1.3e-4, 1.1e-4]), an_iteration([5.2e-4, 5.5e-4, 5.1e-4])
    assert is_worse(other, one)
    assert not is_worse(one, other)


@pytest.mark.parametrize("laps", [[1e-4], [1e-4, 1e-4]])
def test_where_nothing_is_known_of_noise_any_larger_error_is_worse(laps: list[float]) -> None:
    assert is_worse(an_iteration([lap * (1 + 1e-9) for lap in laps]), an_iteration(laps))
    assert not is_worse(an_iteration(laps), an_iteration(laps))


def test_every_axis_adds_its_noise() -> None:
    made = Circumstances({"P": [50.0, 50.0], "D": [14.0, 14.0]})

    def both(error: float, deviation: float) -> Iteration:
        errors = {
            "com.z": AxisError(error, laps=5, deviation=1e-6),
            "com.x": AxisError(1e-3, laps=5, deviation=deviation),
        }
        return Iteration(1, np.zeros((2, 3)), errors=errors, circumstances=made)

    assert is_worse(both(1.1e-3, 1e-6), both(1e-3, 1e-6))
    assert not is_worse(both(1.1e-3, 1e-3), both(1e-3, 1e-3))


def test_as_good_ones_are_taken_for_worse_as_rarely_as_stated() -> None:
    rng = np.random.default_rng(0)
    pairs = rng.normal(1e-3, 1e-4, (4000, 2, 4)).tolist()
    wrong = sum(is_worse(an_iteration(one), an_iteration(other)) for one, other in pairs)
    # 4 expected, 12 or more would be one in a thousand
    assert wrong < 3 * len(pairs) * WORSE_LEVEL
