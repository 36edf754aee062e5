"""Feedforward terms that do harm, made from one that fits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from tsd_casadi.encoding.harmonics import sample_phases
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.state import Matrix, Vector

Change = Callable[[Matrix, Vector], Matrix]
_rng = np.random.default_rng(0)


def _times(factor: float) -> Change:
    return lambda u, phase: factor * u


def _plus(wave: Callable[[Vector], Vector]) -> Change:
    # with something along the first axis that the robot does not need
    return lambda u, phase: np.vstack((u[:1] + wave(phase), u[1:]))


def _only(wave: Callable[[Vector], Vector]) -> Change:
    return lambda u, phase: np.vstack((wave(phase)[None, :], 0 * u[1:]))


def _pulse(phase: Vector) -> Vector:
    # over a quarter of the lap
    return np.asarray(np.where(np.abs(np.angle(np.exp(1j * phase))) < np.pi / 4, 1.0, 0.0))


_noise = _rng.standard_normal((3, 12))


def _random(phase: Vector) -> Vector:
    harmonics = np.arange(1, 7)[:, None] * phase
    return np.asarray(_noise[0, :6] @ np.sin(harmonics) + _noise[0, 6:] @ np.cos(harmonics))


# accelerations in m/s^2; a robot lighter by a tenth needs about -0.9
KINDS: Mapping[str, Change] = {
    "sign flipped": _times(-1.0),
    "half of it, sign flipped": _times(-0.5),
    "twice, sign flipped": _times(-2.0),
    "2.2 times": _times(2.2),
    "2.5 times": _times(2.5),
    "3 times": _times(3.0),
    "5 times": _times(5.0),
    "a load taken for a lack of one": _only(lambda phase: np.full_like(phase, 0.8)),
    "upwards, far too much": _only(lambda phase: np.full_like(phase, 2.5)),
    "first harmonic, late": _plus(lambda phase: 5 * np.sin(phase)),
    "first harmonic, early": _plus(lambda phase: -5 * np.sin(phase)),
    "a quarter of a lap late": _plus(lambda phase: 5 * np.cos(phase)),
    "second harmonic": _plus(lambda phase: 6 * np.sin(2 * phase)),
    "third harmonic": _plus(lambda phase: 8 * np.cos(3 * phase)),
    "a pulse up": _plus(lambda phase: 5 * _pulse(phase)),
    "a pulse down": _plus(lambda phase: -5 * _pulse(phase)),
    "a pulse at the other end": _plus(lambda phase: -5 * _pulse(phase + np.pi)),
    "nothing but the motion, twice as fast": _only(lambda phase: 6 * np.sin(2 * phase)),
    "noise of a lap": _plus(lambda phase: 3 * _random(phase)),
    "upwards and to and fro": _only(lambda phase: 1.6 + 3 * np.sin(phase)),
}


def harmful_terms(fits: Feedforward) -> dict[str, Feedforward]:
    """Make one of each kind.

    Args:
        fits: What the robot needs; the axis that moves first.
    """
    basis: PeriodicBasis = fits.basis
    phase = sample_phases()
    return {
        name: replace(fits, weights=basis.fit(phase, change(fits.mean(phase), phase)))
        for name, change in KINDS.items()
    }
