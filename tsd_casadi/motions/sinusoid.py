"""Offsets of motions that are sinusoids of the phase."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tsd_casadi.motions.motion import Offset


def sinusoid(amplitude: float, phase: float, lead: Sequence[float] = (0.0,)) -> Offset:
    """Compute A sin(phi + lead) on each axis.

    Args:
        amplitude: A [m, rad].
        phase: phi [rad].
        lead: Of each axis, (k,) [rad].
    """
    # on one or two numbers each NumPy's own take longer
    sine = np.array([amplitude * math.sin(phase + ahead) for ahead in lead])
    cosine = np.array([amplitude * math.cos(phase + ahead) for ahead in lead])
    return Offset(sine, cosine, -sine)
