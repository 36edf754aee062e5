from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi.encoding.laps import Lap, fit_laps
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.scatter import Scatter, power_of, scatter_of
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.measured_errors import with_scatter

BASIS = PeriodicBasis()
PHASE = np.linspace(0, 2 * np.pi, 500, endpoint=False)


def laps(count: int, noise: float, seed: int = 0, drift: float = 0.0) -> list[Lap]:
    """Laps of two axes, a sine each, the second with noise of ten times as much."""
    rng = np.random.default_rng(seed)
    scale = noise * np.array([[1.0], [10.0]])
    return [
        Lap(PHASE, np.sin(PHASE) + drift * lap + scale * rng.standard_normal((2, 500)))
        for lap in range(count)
    ]


def test_laps_that_do_not_differ_have_no_scatter() -> None:
    scatter = fit_laps(laps(3, 0.0), BASIS).scatter
    assert scatter is not None
    np.testing.assert_array_equal(scatter.signal, 0.0)
    np.testing.assert_array_equal(scatter.uncertainty(BASIS.L), np.zeros((2, BASIS.L)))


def test_one_lap_tells_nothing_of_it() -> None:
    assert fit_laps(laps(1, 0.1), BASIS).scatter is None


@pytest.mark.parametrize("drift", [0.0, 0.01])
def test_scatter_is_that_of_the_noise_whatever_drifts_slowly(drift: float) -> None:
    scatter = fit_laps(laps(40, 0.1, drift=drift), BASIS).scatter
    assert scatter is not None
    # white noise at 500 phases, of which L parameters take their share each
    expected = 0.1 * np.sqrt(BASIS.L / 500)
    np.testing.assert_allclose(scatter.signal, [expected, 10 * expected], rtol=0.1)


def test_uncertainty_is_that_of_the_weights_of_the_mean_lap() -> None:
    fits = [fit_laps(laps(4, 0.1, seed), BASIS) for seed in range(60)]
    weights = np.array([fit.feedback for fit in fits])
    told = np.array([fit.scatter.uncertainty(BASIS.L) for fit in fits if fit.scatter is not None])
    seen = np.sqrt(weights.var(axis=0, ddof=1).mean(axis=1))
    np.testing.assert_allclose(np.sqrt((told**2).mean(axis=(0, 2))), seen, rtol=0.15)


def test_mean_of_four_laps_is_twice_as_certain() -> None:
    scatter = Scatter(4, np.array([2.0]), np.array([6.0]))
    assert scatter.of_mean == 1.0
    np.testing.assert_array_equal(scatter.uncertainty(3), [[3.0, 3.0, 3.0]])


def test_power_is_the_mean_square_over_the_phase() -> None:
    weights = BASIS.fit(PHASE, np.vstack([np.full(500, 2.0), np.sin(PHASE)]))
    np.testing.assert_allclose(power_of(weights, BASIS), [4.0, 0.5], rtol=1e-3)
    assert scatter_of([weights, -weights], BASIS).signal[0] == pytest.approx(2 * np.sqrt(2))


def test_errors_say_how_many_laps_and_how_they_differ() -> None:
    zeros = np.zeros((1, 500))
    made = [Lap(PHASE, zeros, np.full((1, 500), error), zeros) for error in (1e-3, -3e-3)]
    errors = with_scatter({"com.z": AxisError(2e-3)}, made, Scatter(2, np.ones(1), np.ones(1)))
    assert errors["com.z"].laps == 2
    assert errors["com.z"].deviation == pytest.approx(np.sqrt(2) * 1e-3)
    assert errors["com.z"].scatter == 1.0


def test_errors_of_laps_without_positions_say_only_how_many() -> None:
    bare = [Lap(PHASE, np.zeros((1, 500)))] * 2
    told = with_scatter({"com.z": AxisError(2e-3)}, bare, None)["com.z"]
    assert (told.laps, told.deviation, told.scatter) == (2, None, None)
