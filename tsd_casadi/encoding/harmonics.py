r"""Weights of a periodic basis and the harmonics of the signal they make.

.. math:: f(\phi) = \sum_{n=-N}^{N} c_n e^{j n \phi}, \qquad c_{-n} = \bar c_n

L basis functions hold N = (L - 1) / 2 harmonics and the mean.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.state import Matrix, Vector

Harmonics = NDArray[np.complex128]

# phases at which signals are sampled: more than twice any harmonic in use
SAMPLES = 256


def sample_phases() -> Vector:
    """Compute the phases of sampled signals, (SAMPLES,) [rad]."""
    return 2 * np.pi * np.arange(SAMPLES) / SAMPLES


def highest_harmonic(basis: PeriodicBasis) -> int:
    """Compute N, the number of harmonics that a basis holds, at least 1."""
    return max(1, min((basis.L - 1) // 2, SAMPLES // 2 - 1))


def to_harmonics(basis: PeriodicBasis, weights: Matrix) -> Harmonics:
    """Compute the harmonics of a signal.

    Args:
        weights: (k, L).

    Returns:
        c_0 ... c_N, (k, N + 1), in the weights' unit.
    """
    return analyze(weights @ sampled_values(basis).T, highest_harmonic(basis))


def to_weights(basis: PeriodicBasis, harmonics: Harmonics) -> Matrix:
    """Fit the weights of the signal with these harmonics.

    Args:
        harmonics: (k, N + 1).

    Returns:
        (k, L), by least squares.
    """
    return basis.fit(sample_phases(), synthesize(harmonics))


def analyze(signals: Matrix, highest: int) -> Harmonics:
    """Compute the harmonics of sampled signals.

    Args:
        signals: (k, SAMPLES).
        highest: N.

    Returns:
        (k, N + 1).
    """
    return np.asarray(np.fft.rfft(signals, axis=-1)[..., : highest + 1] / SAMPLES)


def synthesize(harmonics: Harmonics) -> Matrix:
    """Sample the signals with these harmonics.

    Args:
        harmonics: (k, N + 1).

    Returns:
        (k, SAMPLES).
    """
    spectrum = np.zeros((len(harmonics), SAMPLES // 2 + 1), dtype=complex)
    spectrum[:, : harmonics.shape[1]] = harmonics
    return np.asarray(np.fft.irfft(SAMPLES * spectrum, SAMPLES, axis=-1))


@lru_cache(maxsize=8)
def sampled_values(basis: PeriodicBasis) -> Matrix:
    """Compute the basis at the sampled phases, (SAMPLES, L)."""
    return basis.values(sample_phases())
