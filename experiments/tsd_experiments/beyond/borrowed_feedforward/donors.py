"""What a feedforward is borrowed from: other squats, other robots, the wrong phase."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tsd_casadi.encoding.harmonics import sample_phases
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_experiments.harness.case import TALL, Case

Weights = list[float]


@dataclass(frozen=True)
class Donor:
    """Where a feedforward is borrowed from.

    Attributes:
        name: For tables.
        case: What it was learned in, from what it is used in.
        change: What happens to its weights on the way.
    """

    name: str
    case: Callable[[Case], Case]
    change: Callable[[Weights], Weights]


def _same(case: Case) -> Case:
    return case


def _unchanged(weights: Weights) -> Weights:
    return weights


def shift_by_half_a_lap(weights: Weights) -> Weights:
    """Fit the weights of u(phi + pi): the right mean, the wrong time.

    Args:
        weights: Of u, (L,) [m/s^2].
    """
    basis, phase = PeriodicBasis.of_size(len(weights)), sample_phases()
    later = basis.evaluate(phase + np.pi, np.array([weights]))
    return [float(weight) for weight in basis.fit(phase, later)[0]]


DONORS = (
    Donor("5 cm instead of 3", lambda case: replace(case, amplitude=0.05), _unchanged),
    Donor("5.5 cm taller", lambda case: replace(case, height=TALL), _unchanged),
    Donor(
        "other frequency", lambda case: replace(case, frequency=0.75 - case.frequency), _unchanged
    ),
    Donor("half a lap late", _same, shift_by_half_a_lap),
    Donor("1.5 times", _same, lambda weights: [1.5 * weight for weight in weights]),
    # the error without feedforward is that of twice the feedforward, with the other sign
    Donor("1.9 times", _same, lambda weights: [1.9 * weight for weight in weights]),
    Donor("2.2 times", _same, lambda weights: [2.2 * weight for weight in weights]),
    Donor("3 times", _same, lambda weights: [3 * weight for weight in weights]),
    Donor("sign flipped", _same, lambda weights: [-weight for weight in weights]),
    Donor("-10 % robot", lambda case: replace(case, model_error=-0.1), _unchanged),
)
QUICK_DONORS = ("5 cm instead of 3", "half a lap late", "sign flipped")
