from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, DotProduct, Exponentiation, Matern

from tsd_casadi.generalization import gaussian_process
from tsd_casadi.generalization.gaussian_process import NEAREST, GaussianProcess
from tsd_casadi.generalization.kernel import NEXT_DEGREE, PLANE, Kernel

KERNEL = Kernel(0.2, 0.4, 1e-3, np.array([0.8, 1.7]))


def data(seed: int, count: int = 9) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places, targets that are smooth with some noise, and noise that is known."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-1, 1, (count, 2))
    phase = np.arange(5)
    targets = np.sin(places[:, :1] + phase) + places[:, 1:] ** 2 * np.cos(phase)
    return places, targets + 0.01 * rng.normal(size=targets.shape), rng.uniform(0, 1e-3, count)


def reference(kernel: Kernel, noise: np.ndarray) -> GaussianProcessRegressor:
    """The same in scikit-learn; the noise, that of the kernel too, is its alpha."""
    product = DotProduct(0.0, "fixed")
    same = (
        ConstantKernel(PLANE)
        + ConstantKernel(PLANE) * product
        + ConstantKernel(kernel.higher / 4) * Exponentiation(product, 2)
        + ConstantKernel(NEXT_DEGREE * kernel.higher / 4) * Exponentiation(product, 3)
        + ConstantKernel(kernel.rough) * Matern(kernel.lengths, nu=2.5)
    )
    return GaussianProcessRegressor(same, alpha=kernel.noise + noise, optimizer=None)


@pytest.mark.parametrize("seed", range(3))
def test_it_predicts_what_scikit_learn_does(seed: int) -> None:
    places, targets, noise = data(seed)
    process = GaussianProcess(KERNEL, places, targets, noise)
    expected = reference(KERNEL, noise).fit(places, targets)
    asked = np.random.default_rng(seed).uniform(-1.5, 1.5, (5, 2))
    means, deviations = expected.predict(asked, return_std=True)
    for place, mean, deviation in zip(asked, means, deviations[:, 0], strict=True):
        found, off = process.predict(place)
        np.testing.assert_allclose(found, mean, atol=1e-8)
        assert off == pytest.approx(np.sqrt(deviation**2 + KERNEL.noise), rel=1e-6)
    np.testing.assert_allclose(
        process.deviations(asked), np.sqrt(deviations[:, 0] ** 2 + KERNEL.noise), rtol=1e-6
    )


def test_the_likelihood_is_that_of_scikit_learn_with_its_gradient() -> None:
    places, targets, noise = data(0)
    theta = np.log([0.2, 0.4, 1e-3, 0.8, 1.7])

    def unlikelihood(at: np.ndarray) -> float:
        return gaussian_process._unlikelihood(at, places, targets, noise)[0]

    expected = reference(KERNEL, noise).fit(places, targets).log_marginal_likelihood()
    constant = targets.size * np.log(2 * np.pi) / 2
    assert unlikelihood(theta) == pytest.approx(-expected - constant, rel=1e-9)
    gradient = gaussian_process._unlikelihood(theta, places, targets, noise)[1]
    np.testing.assert_allclose(gradient, approx_fprime(theta, unlikelihood, 1e-6), rtol=1e-3)


def test_fitted_hyperparameters_are_more_probable_than_others() -> None:
    places, targets, noise = data(1, 12)
    fitted = GaussianProcess.fitted(places, targets, noise).kernel
    found = (fitted.higher, fitted.rough, fitted.noise)
    theta = np.log([*found, *fitted.lengths])
    medians = np.log([*gaussian_process.MEDIANS, *[gaussian_process.LENGTH] * 2])
    spreads = np.array([*[gaussian_process.SPREAD] * 3, *[gaussian_process.LENGTH_SPREAD] * 2])

    def cost(at: np.ndarray) -> float:
        unlikely, _ = gaussian_process._unlikelihood(at, places, targets, noise)
        return unlikely + float(np.sum(((at - medians) / spreads) ** 2)) / 2

    for index in range(len(theta)):
        for step in (-0.2, 0.2):
            moved = theta.copy()
            moved[index] += step
            if abs(moved[index] - medians[index]) < gaussian_process.REACH * spreads[index]:
                assert cost(moved) > cost(theta) - 1e-3


def test_an_entry_that_is_known_to_be_noisy_pulls_less() -> None:
    places, targets, noise = data(2)
    wrong = targets.copy()
    wrong[4] += 1.0
    noisy = noise.copy()
    noisy[4] = 1e3
    asked = places[4] + 0.1
    without = np.arange(len(places)) != 4
    alone = GaussianProcess(KERNEL, places[without], targets[without], noise[without])
    known = GaussianProcess(KERNEL, places, wrong, noisy)
    unknown = GaussianProcess(KERNEL, places, wrong, noise)
    expected = alone.predict(asked)[0]
    np.testing.assert_allclose(known.predict(asked)[0], expected, atol=0.01)
    assert np.abs(unknown.predict(asked)[0] - expected).max() > 0.2


def test_many_entries_are_predicted_from_the_nearest(monkeypatch: pytest.MonkeyPatch) -> None:
    places, targets, noise = data(3, NEAREST + 40)
    near = GaussianProcess(KERNEL, places, targets, noise)
    monkeypatch.setattr(gaussian_process, "NEAREST", len(places))
    everything = GaussianProcess(KERNEL, places, targets, noise)
    for place in places[:5] + 0.01:
        np.testing.assert_allclose(near.predict(place)[0], everything.predict(place)[0], atol=5e-3)
        assert near.predict(place)[1] == pytest.approx(everything.predict(place)[1], rel=0.05)
    np.testing.assert_allclose(near.deviations(places), everything.deviations(places), rtol=1e-9)


def test_many_places_are_taken_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    places, targets, noise = data(4)
    process = GaussianProcess(KERNEL, places, targets, noise)
    asked = np.random.default_rng(0).uniform(-1, 1, (7, 2))
    at_once = process.deviations(asked)
    monkeypatch.setattr(gaussian_process, "TOGETHER", 3)
    np.testing.assert_allclose(process.deviations(asked), at_once, rtol=1e-7)
