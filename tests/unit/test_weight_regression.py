from __future__ import annotations

import re
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import EntryNotFound, OutsideTrainedRange
from tsd_casadi.generalization import weight_regression
from tsd_casadi.generalization.kernel import NEXT_DEGREE, PLANE
from tsd_casadi.generalization.predictive_deviation import student_factor
from tsd_casadi.generalization.weight_regression import KNOWN, WeightRegression
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.squat import Squat

AMPLITUDES = (0.02, 0.04, 0.06, 0.08)
FREQUENCIES = (0.2, 0.4, 0.6)
GRID = tuple((a, f) for a in AMPLITUDES for f in FREQUENCIES)
NAMES = ("amplitude", "frequency")
BASIS = PeriodicBasis()
DECLARATION = Squat.declaration()
SHAPE = (2, BASIS.L)
LAP = np.linspace(0, 2 * np.pi, 100, endpoint=False)

Places = tuple[tuple[float, ...], ...]


def learned(place: tuple[float, ...], seed: int = 0) -> np.ndarray:
    """Weights that depend smoothly on the parameters, each in its own way.

    Inertia, damping, and friction, whose steps at the turning points are the
    sharper the faster.
    """
    rng = np.random.default_rng(seed)
    inertia, damping, friction = rng.uniform(0.5, 1.5, size=(3, 2, 1))
    amplitude, frequency = (*place, 0.25)[:2]
    speed = 2 * np.pi * amplitude * frequency
    return np.asarray(
        -0.7
        + inertia * 0.1 * amplitude * (2 * np.pi * frequency) ** 2 * np.sin(BASIS.centers)
        + damping * speed * np.cos(BASIS.centers)
        + friction * 0.5 * np.tanh(np.cos(BASIS.centers) * speed / 0.05)
    )


@cache
def regression_of(places: Places = GRID, seed: int = 0) -> WeightRegression:
    return WeightRegression(
        DECLARATION,
        NAMES[: len(places[0])],
        np.array(places),
        [learned(place, seed) for place in places],
        BASIS,
    )


def at(*place: float) -> dict[str, float]:
    return dict(zip(NAMES, place, strict=False))


def along(*amplitudes: float) -> Places:
    return tuple((amplitude,) for amplitude in amplitudes)


class ClosedForm:
    """The Gaussian process posterior of one axis, written out with numpy."""

    def __init__(self, regression: WeightRegression, places: Places, seed: int, axis: int) -> None:
        self.kernel = regression._processes[axis].kernel  # exact; the string is rounded
        inputs = np.array(places)
        self.x, self.coordinates = regression._coordinates.places(inputs), regression._coordinates
        self.y = np.stack([learned(place, seed)[axis] for place in places])
        self.center = self.y.mean(axis=0)
        # of the slope of a plane: 1 / sqrt(12) is how even values between 0 and 1 scatter
        shares = (inputs - inputs.min(axis=0)) / np.ptp(inputs, axis=0)
        width = np.sqrt(12 * np.mean(shares.var(axis=0)))
        self.spread = np.sqrt(np.mean(self.y.var(axis=0))) / width
        # no entry is known exactly
        self.known = (KNOWN / self.spread) ** 2

    def covariance(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        k = self.kernel
        r = np.linalg.norm(one[:, None] / k.lengths - other[None] / k.lengths, axis=2)
        matern = (1 + np.sqrt(5) * r + 5 / 3 * r**2) * np.exp(-np.sqrt(5) * r)
        dot = one @ other.T
        higher = k.higher * (dot / one.shape[1]) ** 2 * (1 + NEXT_DEGREE * dot)
        trend = PLANE * (1 + dot) + higher
        return np.asarray(trend + k.rough * matern)

    def predict(self, x: np.ndarray, used: np.ndarray) -> tuple[np.ndarray, float]:
        """Mean, and standard deviation in units of the spread, from some entries."""
        noise = self.kernel.noise + self.known
        K = self.covariance(self.x[used], self.x[used]) + noise * np.eye(used.sum())
        k = self.covariance(x[None], self.x[used])[0]
        mean = self.center + k @ np.linalg.solve(K, self.y[used] - self.center)
        variance = self.covariance(x[None], x[None])[0, 0] - k @ np.linalg.solve(K, k)
        return mean, float(np.sqrt(variance + self.kernel.noise))

    def calibrated(self, place: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
        """Mean, and its calibrated standard deviation over a lap, leaving out for real."""
        n, parameters = self.x.shape
        everything = np.ones(n, dtype=bool)
        mean, deviation = self.predict(self.coordinates.places(np.array([place]))[0], everything)
        phase = 2 * np.pi * np.arange(8 * BASIS.L) / (8 * BASIS.L)
        psi, squares = BASIS.values(phase), []
        for i in range(n):
            others = everything.copy()
            others[i] = False
            left_out, unlearned = self.predict(self.x[i], others)
            expected = np.hypot(unlearned, np.sqrt(self.known))
            squares.append((psi @ (self.y[i] - left_out) / expected / self.spread) ** 2)
        square = np.mean(squares, axis=0)
        square = (n * square + 4 * square.mean() + 1) / (n + 5)
        if n == parameters + 1:
            square = np.ones_like(square)
        scale = student_factor(n, parameters) * np.sqrt(square @ psi / psi.sum(axis=0))
        return mean, deviation * self.spread * scale


@pytest.mark.parametrize(
    ("places", "place", "seed"),
    [
        (along(*AMPLITUDES), (0.025,), 0),
        (along(*AMPLITUDES), (0.1,), 1),
        (along(0.02, 0.06), (0.04,), 0),
        (GRID, (0.0612, 0.31), 0),
        (GRID, (0.08, 0.6), 1),
        (GRID, (0.1, 0.7), 0),
    ],
)
def test_prediction_is_the_closed_form(places: Places, place: tuple[float, ...], seed: int) -> None:
    regression = regression_of(places, seed)
    mean, std = regression.predict(at(*place), extrapolate=True)
    for axis in range(SHAPE[0]):
        closed = ClosedForm(regression, places, seed, axis)
        expected_mean, expected_std = closed.calibrated(place)
        np.testing.assert_allclose(mean[axis], expected_mean, rtol=0, atol=1e-7)
        np.testing.assert_allclose(std[axis], expected_std, rtol=1e-4)


def test_learned_values_are_nearly_reproduced() -> None:
    for place in GRID:
        mean, _ = regression_of().predict(at(*place))
        assert np.sqrt(np.mean((mean - learned(place)) ** 2)) < 2e-3


def held_out(seed: int, count: int = 40) -> np.ndarray:
    return np.random.default_rng(seed).uniform((0.02, 0.2), (0.08, 0.6), size=(count, 2))


@pytest.mark.parametrize("seed", range(3))
def test_between_the_entries_it_beats_linear_interpolation(seed: int) -> None:
    places = held_out(seed)
    x, low = np.array(GRID), np.array(GRID).min(axis=0)
    span = np.ptp(x, axis=0)
    weights = np.stack([learned(place, seed).ravel() for place in GRID])
    linear = LinearNDInterpolator((x - low) / span, weights)((places - low) / span)
    truth = np.stack([learned(tuple(place), seed).ravel() for place in places])
    found = np.stack([regression_of(GRID, seed).predict(at(*p))[0].ravel() for p in places])
    assert np.mean((found - truth) ** 2) < 0.5 * np.mean((linear - truth) ** 2)


def coverage(entries: int, seed: int) -> float:
    """Share of the held-out curves inside two standard deviations; entries that are noisy."""
    rng = np.random.default_rng(100 + seed)
    corners = [(a, f) for a in (0.02, 0.08) for f in (0.2, 0.6)]
    inside = rng.uniform((0.02, 0.2), (0.08, 0.6), size=(entries - 4, 2))
    places = np.concatenate([corners, inside])

    def noisy(place: np.ndarray) -> np.ndarray:
        return learned(tuple(place), seed) + 0.002 * rng.normal(size=SHAPE)

    regression = WeightRegression(DECLARATION, NAMES, places, [noisy(p) for p in places], BASIS)
    shares = []
    for place in held_out(seed, 20):
        mean, std = regression.predict(at(*place))
        found = Feedforward(("x", "z"), BASIS, mean, std, "generalised")
        error = np.abs(found.mean(LAP) - noisy(place) @ BASIS.values(LAP).T)
        shares.append(np.mean(error < 2 * found.std(LAP)))
    return float(np.mean(shares))


@pytest.mark.parametrize("entries", [6, 12])
def test_two_standard_deviations_hold_the_held_out_curves(entries: int) -> None:
    shares = [coverage(entries, seed) for seed in range(12)]
    assert 0.85 <= np.mean(shares) <= 0.995
    assert min(shares) >= 0.5


def test_a_parameter_without_effect_has_none() -> None:
    weights = [learned((amplitude, 0.3)) for amplitude, _ in GRID]
    regression = WeightRegression(DECLARATION, NAMES, np.array(GRID), weights, BASIS)
    one, other = (regression.predict(at(0.05, frequency))[0] for frequency in (0.25, 0.55))
    np.testing.assert_allclose(one, other, atol=1e-3)
    np.testing.assert_allclose(one, learned((0.05, 0.3)), atol=1e-2)


def test_what_steps_along_one_parameter_has_a_short_length_scale_there() -> None:
    """Steps are no polynomial: that what is left of the trend says how far it goes on."""
    weights = [np.full(SHAPE, np.sign(amplitude - 0.05)) + 0.1 * f for amplitude, f in GRID]
    regression = WeightRegression(DECLARATION, NAMES, np.array(GRID), weights, BASIS)
    scales = regression.length_scales
    assert scales["frequency"] > 1.5 * scales["amplitude"]


@pytest.mark.parametrize("ends", [(0.02, 0.08), (0.04, 0.05)])
def test_two_entries_tell_nothing_of_what_lies_between_them(ends: tuple[float, float]) -> None:
    regression = regression_of(along(*ends))
    middle = sum(ends) / 2
    mean, deviation = regression.predict(at(middle))
    off = np.abs((mean - learned((middle,))) @ BASIS.values(LAP).T)
    assert np.mean(off <= 2 * deviation @ BASIS.values(LAP).T) > 0.9


def test_uncertainty_grows_away_from_the_entries() -> None:
    places = [(0.08, 0.6), (0.09, 0.65), (0.12, 0.8), (0.3, 2.0)]
    deviations = [
        regression_of().predict(at(*place), extrapolate=True)[1].mean() for place in places
    ]
    assert all(near < far for near, far in pairwise(deviations))


def test_an_empty_corner_is_more_uncertain() -> None:
    places = tuple(place for place in GRID if place[0] < 0.05 or place[1] < 0.3)
    regression = regression_of(places)
    corner = regression.predict(at(0.08, 0.6))[1].mean()
    assert corner > 3 * regression.predict(at(0.03, 0.3))[1].mean()


def test_deviation_is_the_rms_of_the_standard_deviation_over_a_lap() -> None:
    regression = regression_of()
    places = held_out(0, 5)
    for place, deviation in zip(places, regression.deviation(places), strict=True):
        _, std = regression.predict(at(*place))
        curve = BASIS.evaluate(LAP, std)
        assert deviation == pytest.approx(np.sqrt(np.mean(curve**2)), rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_order_of_entries_does_not_matter(seed: int) -> None:
    order = np.random.default_rng(seed).permutation(len(GRID))
    shuffled = regression_of(tuple(GRID[i] for i in order))
    place = at(0.05, 0.3)
    for one, other in zip(shuffled.predict(place), regression_of().predict(place), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-2, atol=1e-4)


def test_the_same_content_gives_the_same_answer() -> None:
    first = regression_of()
    regression_of.cache_clear()
    place = at(0.05, 0.3)
    for one, other in zip(regression_of().predict(place), first.predict(place), strict=True):
        np.testing.assert_array_equal(one, other)


def test_input_arrays_are_not_changed() -> None:
    weights = [learned(place) for place in GRID]
    inputs = np.array(GRID)
    before = [array.copy() for array in (*weights, inputs)]
    WeightRegression(DECLARATION, NAMES, inputs, weights, BASIS).predict(at(0.05, 0.3))
    for one, other in zip((*weights, inputs), before, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("value", [0.0199, 0.0801, 0.0, -1.0, np.nan, np.inf])
def test_outside_the_learned_range_is_refused_with_the_range(value: float) -> None:
    with pytest.raises(OutsideTrainedRange, match=re.escape("0.02 to 0.08 m")) as caught:
        regression_of().predict(at(value, 0.3))
    assert (caught.value.low, caught.value.high) == (0.02, 0.08)
    assert caught.value.parameter == "amplitude"
    assert "extrapolate=true" in str(caught.value)


@pytest.mark.parametrize("value", [0.19, 0.61])
def test_the_parameter_that_is_outside_is_named_with_its_unit(value: float) -> None:
    message = f"frequency {value:g} Hz is outside the learned range 0.2 to 0.6 Hz"
    with pytest.raises(OutsideTrainedRange, match=re.escape(message)):
        regression_of().predict(at(0.05, value))
    mean, std = regression_of().predict(at(0.05, value), extrapolate=True)
    assert np.isfinite(mean).all()
    assert (std > 0).all()


@pytest.mark.parametrize(("places", "least"), [(((0.05,),), 2), (((0.02, 0.2), (0.04, 0.4)), 3)])
def test_too_few_entries_are_refused(places: Places, least: int) -> None:
    with pytest.raises(EntryNotFound, match=f"at least {least}"):
        regression_of(places)


def test_weights_that_never_differ_are_predicted_as_they_are() -> None:
    weights = [np.full(SHAPE, 0.7)] * 3
    inputs = np.array([[0.02], [0.04], [0.06]])
    regression = WeightRegression(DECLARATION, ("amplitude",), inputs, weights, BASIS)
    mean, std = regression.predict(at(0.05))
    np.testing.assert_allclose(mean, 0.7, atol=1e-12)
    assert np.isfinite(std).all()


def test_what_was_fitted_can_be_shown() -> None:
    regression = regression_of()
    assert len(regression.kernels) == SHAPE[0]
    assert all("Matern" in kernel and "noise" in kernel for kernel in regression.kernels)
    assert regression.length_scales.keys() == set(NAMES)
    calibration = regression.calibration
    assert calibration["unit"] == "m/s^2"
    assert calibration["student_factor"] == student_factor(12, 2)
    squares = []
    for axis in range(SHAPE[0]):
        closed = ClosedForm(regression, GRID, 0, axis)
        residual = closed.y[7] - closed.predict(closed.x[7], np.arange(12) != 7)[0]
        squares.append((BASIS.values(LAP) @ residual) ** 2)
    assert calibration["residuals"][7] == pytest.approx(np.sqrt(np.mean(squares)), rel=1e-3)


def test_the_bands_are_around_the_deviation() -> None:
    regression = regression_of()
    _, deviation = regression.predict(at(0.05, 0.3))
    pointwise, simultaneous = regression.bands(deviation)
    assert (pointwise.kind, simultaneous.kind) == ("pointwise", "simultaneous")
    np.testing.assert_array_equal(pointwise.half_width, 2 * deviation)
    factors = np.array(regression.calibration["band_factors"])[:, None]
    np.testing.assert_allclose(simultaneous.half_width, factors * deviation)
    assert (simultaneous.half_width > pointwise.half_width).all()


@pytest.mark.parametrize(
    ("frequencies", "accuracy"),
    [
        # of three values a cubic may be what a line is: the range of f^2 is 0.32
        ((0.2, 0.4, 0.6), 0.015),
        ((0.2, 0.3, 0.4, 0.6), 1e-3),
    ],
)
def test_a_polynomial_of_the_parameters_is_found(
    frequencies: tuple[float, ...], accuracy: float
) -> None:
    sine, cosine = np.sin(BASIS.centers), np.cos(BASIS.centers)
    places = [(a, f) for a in AMPLITUDES for f in frequencies]
    weights = [np.stack([a * sine + f**2 * cosine, a * f * sine]) for a, f in places]
    regression = WeightRegression(DECLARATION, NAMES, np.array(places), weights, BASIS)
    assert not regression._coordinates.by_ratio
    mean, _ = regression.predict(at(0.03, 0.5))
    np.testing.assert_allclose(mean[0], 0.03 * sine + 0.25 * cosine, atol=accuracy)


def test_a_polynomial_of_four_entries_counts_straight() -> None:
    """The fewest with which it is told: by ratios a curve through them is off."""
    sine, cosine = np.sin(BASIS.centers), np.cos(BASIS.centers)
    weights = [np.stack([a * sine + 4 * a**2 * cosine] * 2) for a in AMPLITUDES]
    inputs = np.array(AMPLITUDES)[:, None]
    regression = WeightRegression(DECLARATION, NAMES[:1], inputs, weights, BASIS)
    assert not regression._coordinates.by_ratio
    mean, _ = regression.predict(at(0.05))
    np.testing.assert_allclose(mean[0], 0.05 * sine + 4 * 0.05**2 * cosine, atol=2e-4)


def test_the_acceleration_of_a_motion_is_found() -> None:
    """Amplitude times the square of the frequency, of third degree."""
    places = [(a, f) for a in AMPLITUDES for f in (0.2, 0.3, 0.4, 0.5, 0.6)]
    sine = np.sin(BASIS.centers)
    weights = [np.stack([a * f**2 * sine, a**2 * f * sine]) for a, f in places]
    regression = WeightRegression(DECLARATION, NAMES, np.array(places), weights, BASIS)
    mean, _ = regression.predict(at(0.03, 0.45))
    np.testing.assert_allclose(mean[0], 0.03 * 0.45**2 * sine, atol=2e-5)


def test_what_friction_makes_counts_by_ratios() -> None:
    assert regression_of()._coordinates.by_ratio


def test_more_entries_than_are_fitted_all_count() -> None:
    rng = np.random.default_rng(5)
    places = rng.uniform((0.02, 0.2), (0.08, 0.6), (40, 2))
    weights = [learned(tuple(place)) for place in places]
    last = tuple(places[-1])
    weights[-1] = weights[-1] + 0.01  # beyond the sample, and little enough to be believed
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(weight_regression, "FITTED", 10)
        kept = weights[-2]
        weights[-2] = -kept
        regression = WeightRegression(DECLARATION, NAMES, places, weights, BASIS)
        assert 38 in regression.disagreeing
    mean, _ = regression.predict(at(*last), extrapolate=True)
    np.testing.assert_allclose(mean, weights[-1], atol=8e-3)
