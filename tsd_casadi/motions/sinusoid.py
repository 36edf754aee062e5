"""Offsets of motions that are sinusoids of the phase."""

from __future__ import annotations

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
    angle = phase + np.asarray(lead)
    sine, cosine = np.sin(angle), np.cos(angle)
    return Offset(amplitude * sine, amplitude * cosine, -amplitude * sine)
