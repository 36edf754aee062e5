import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.encoding.harmonics import highest_harmonic, to_harmonics, to_weights
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.adaptive_learning import answered_share, anticipation, update_adaptively
from tsd_casadi.learning.iteration import FittedRepetition
from tsd_casadi.learning.iterative_learning import angular_frequencies
from tsd_casadi.learning.loop_response import LoopResponse
from tsd_casadi.state import Matrix

BASIS = PeriodicBasis()
FREQUENCY, P, D = 0.5, 100.0, 20.0
OMEGA = angular_frequencies(BASIS, FREQUENCY)


def signal(seed: int, size: float = 1.0) -> Matrix:
    """Weights of a smooth signal: three harmonics."""
    rng = np.random.default_rng(seed)
    harmonics = np.zeros((1, highest_harmonic(BASIS) + 1), dtype=complex)
    harmonics[0, :4] = size * (rng.normal(size=4) + 1j * rng.normal(size=4))
    harmonics[0, 0] = harmonics[0, 0].real
    return to_weights(BASIS, harmonics)


def answer(weights: Matrix, needed: Matrix, gain: float, share: float = 1.0) -> Matrix:
    """Error of a linear loop that lacks some of the feedforward and answers to a share of it."""
    T = LoopResponse(gain=gain).transfer(OMEGA, P, D)
    lacking = to_harmonics(BASIS, needed) - share * to_harmonics(BASIS, weights)
    return to_weights(BASIS, T * lacking / (P + 1j * OMEGA * D))


def errors_of(gain: float, share: float, iterations: int) -> list[float]:
    needed = signal(1)
    weights = np.zeros_like(needed)
    repetitions: list[FittedRepetition] = []
    found = []
    for _ in range(iterations + 1):
        error = answer(weights, needed, gain, share)
        found.append(float(np.linalg.norm(to_harmonics(BASIS, error))))
        repetitions.append(FittedRepetition(weights, error, np.zeros_like(error)))
        weights = update_adaptively(repetitions, BASIS, FREQUENCY, [P], [D])
    return found


def test_known_response_is_learned_at_once() -> None:
    errors = errors_of(1.0, 1.0, 2)
    # what the basis itself leaves of a harmonic
    assert errors[1] < 1e-3 * errors[0]
    assert errors[2] <= errors[1]


@pytest.mark.parametrize("gain", [0.4, 0.7, 1.0, 1.3])
@pytest.mark.parametrize("share", [0.4, 0.7, 1.0])
def test_less_answer_than_expected_is_made_up_for(gain: float, share: float) -> None:
    errors = errors_of(gain, share, 6)
    assert errors[6] < 0.02 * errors[0]
    assert max(errors[1:]) < errors[0]


def test_shares_are_bounded() -> None:
    change = np.array([0.0, 1.0 + 1j, 0.5])
    assert answered_share(change, 0.6 * change) == pytest.approx(0.6)
    assert answered_share(change, -change) == 0.25
    assert answered_share(change, 9 * change) == 1.5
    assert answered_share(0 * change, change) == 1.0


@given(st.floats(0, 10))
def test_anticipation_sums_a_geometric_series(left: float) -> None:
    before = np.array([1.0, 2j])
    factor = anticipation(before, left * before)
    if left <= 0.5:
        assert factor == pytest.approx(sum(left**n for n in range(60)), rel=1e-9)
    else:
        assert factor == 2.0


def test_nothing_known_learns_nothing() -> None:
    nothing = np.zeros((1, BASIS.L))
    weights = update_adaptively(
        [FittedRepetition(nothing, nothing, nothing)], BASIS, FREQUENCY, [P], [D]
    )
    np.testing.assert_array_equal(weights, nothing)
