r"""What learning leaves of an error from one repetition to the next, by harmonic.

Predicted of a linear loop: with the share g of the change that is made, at most
:math:`1 - g + g \rho_n`, since :math:`|1 - g L T| \le (1 - g) + g |1 - L T|`
for every response that the data allow (``learning_filter``). Observed:
:math:`|C e_{i+1}| / |C e_i|`, n-th harmonic, i + 1 learned from i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsd_casadi.learning.learning_filter import LearningFilter
from tsd_casadi.state import Vector

Shares = tuple[float | None, ...]


@dataclass(frozen=True)
class Contraction:
    """Harmonics 0 ... N of one axis; plain numbers, so that JSON takes it.

    Attributes:
        axis: Name 'task.axis'.
        frequency: Of each harmonic [Hz].
        plain: |1 - T|, what the plain sum would leave by the estimated response.
        predicted: The most that the stable rule would leave in its next iteration if
            the loop were linear, each harmonic alone; friction leaves more. None
            above the bandwidth, where nothing is learned.
        observed: What was left the last time that it could be told; None if it
            never could. It is that of the rules that were in use.
        lead: l [s].
        bandwidth: Frequency of the highest learned harmonic [Hz].
        gain: Estimated gain of the loop, 1 for a perfect model.
        gain_deviation: Its standard deviation.
        delay: Estimated delay of the loop [s].
        delay_deviation: Its standard deviation [s].
    """

    axis: str
    frequency: tuple[float, ...]
    plain: tuple[float, ...]
    predicted: Shares
    observed: Shares
    lead: float
    bandwidth: float
    gain: float
    gain_deviation: float
    delay: float
    delay_deviation: float

    @classmethod
    def of(
        cls,
        axis: str,
        frequency: float,
        learning_filter: LearningFilter,
        learning_gain: float,
        observed: Vector,
    ) -> Contraction:
        """Describe a filter and what was observed.

        Args:
            axis: Name 'task.axis'.
            frequency: Laps per second [Hz].
            learning_filter: The filter of the next iteration.
            learning_gain: g.
            observed: (N + 1,), NaN where nothing could be told.
        """
        most = 1 - learning_gain + learning_gain * learning_filter.worst_contraction
        response = learning_filter.response
        return cls(
            axis=axis,
            frequency=tuple((frequency * np.arange(len(most))).tolist()),
            plain=tuple(learning_filter.plain_contraction.tolist()),
            predicted=_known(np.where(learning_filter.Q > 0, most, np.nan)),
            observed=_known(observed),
            lead=learning_filter.lead,
            bandwidth=learning_filter.bandwidth,
            gain=response.gain,
            gain_deviation=response.gain_deviation,
            delay=response.delay,
            delay_deviation=response.delay_deviation,
        )


def _known(values: Vector) -> Shares:
    return tuple(None if np.isnan(value) else float(value) for value in values)
