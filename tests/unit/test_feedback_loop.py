from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.feedback_loop import find_loop, require_loop

AXES = ("com.x", "com.z")
GAINS = {"P": [50.0, 20.0], "D": [14.0, 0.0], "W": [1.0]}


def test_the_loop_is_frequency_and_gains_of_the_learned_axes() -> None:
    loop = find_loop(AXES, {"amplitude": 0.03, "frequency": 0.25}, GAINS)
    assert loop == (0.25, [50.0, 20.0], [14.0, 0.0])
    assert require_loop(AXES, {"frequency": 0.25}, GAINS) == loop


@pytest.mark.parametrize(
    ("parameters", "gains"),
    [
        ({}, GAINS),
        ({"frequency": 0.0}, GAINS),
        ({"frequency": np.nan}, GAINS),
        ({"frequency": 0.25}, None),
        ({"frequency": 0.25}, {"P": [50.0, 20.0]}),
        ({"frequency": 0.25}, {**GAINS, "P": [50.0]}),
        ({"frequency": 0.25}, {**GAINS, "P": 50.0}),
        ({"frequency": 0.25}, {**GAINS, "P": [50.0, 0.0]}),
        ({"frequency": 0.25}, {**GAINS, "D": [14.0, -1.0]}),
        ({"frequency": 0.25}, {**GAINS, "P": [50.0, np.inf]}),
    ],
)
def test_what_was_not_told_or_makes_no_sense_is_no_loop(
    parameters: dict[str, float], gains: dict[str, Any] | None
) -> None:
    assert find_loop(AXES, parameters, gains) is None
    with pytest.raises(InvalidValue, match=r"frequency, P and D.*com\.x, com\.z a positive P"):
        require_loop(AXES, parameters, gains or {})
