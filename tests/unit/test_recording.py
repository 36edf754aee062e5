from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.recording import Recording

BASIS = PeriodicBasis()
PHASE = np.linspace(0, 2 * np.pi, 100, endpoint=False)
WAVE = np.sin(PHASE)[None, :]
BARE, WHOLE = Lap(PHASE, WAVE), Lap(PHASE, WAVE, WAVE / 100, WAVE / 20)
HALF = replace(WHOLE, reference=None)
MADE = Circumstances({"P": [50.0], "D": [14.0]}, {}, "0.1.0")


def recording(**changes: Any) -> Recording:
    made = Recording(
        key=EntryKey.of("r", "squat", "1", ("com.z",), {"amplitude": 0.03, "frequency": 0.25}),
        basis=BASIS,
        applied=np.zeros((1, BASIS.L)),
        laps=[WHOLE],
        errors={"com.z": AxisError(1e-3)},
        circumstances=MADE,
    )
    return replace(made, **changes)


@pytest.mark.parametrize(
    ("laps", "expected"),
    [([WHOLE], True), ([BARE], False), ([WHOLE, BARE], False), ([HALF], False)],
)
def test_positions_are_known_where_every_lap_has_both(laps: list[Lap], expected: bool) -> None:
    assert recording(laps=laps).has_positions is expected


def test_a_recording_without_laps_is_refused() -> None:
    with pytest.raises(InvalidValue, match="laps is none"):
        recording(laps=[])


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"applied": np.zeros((1, 3))}, r"the applied weights is 1 x 3, expected 1 x 25"),
        ({"applied": np.zeros((2, 25))}, r"the applied weights is 2 x 25, expected 1 x 25"),
        ({"laps": [WHOLE, Lap(PHASE, np.vstack([WAVE, WAVE]))]}, r"lap 1 is 2 x 100, .* 1 x 100"),
        ({"laps": [Lap(PHASE[:50], WAVE)]}, r"lap 0 is 1 x 100, expected 1 x 50"),
        ({"laps": [replace(WHOLE, error=WAVE[:, :7])]}, r"lap 0 is 1 x 7, expected 1 x 100"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(InvalidValue, match=expected):
        recording(**changes)


@pytest.mark.parametrize("name", ["phase", "feedback", "error", "reference"])
def test_numbers_that_are_not_finite_are_refused(name: str) -> None:
    spoilt = getattr(WHOLE, name).copy()
    spoilt[..., 3] = np.nan
    with pytest.raises(InvalidValue, match="lap 1 is not finite"):
        recording(laps=[WHOLE, replace(WHOLE, **{name: spoilt})])


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"errors": {}}, "errors is of no axis, expected of com.z"),
        ({"errors": {"com.x": AxisError(1e-3)}}, "errors is of com.x, expected of com.z"),
        ({"errors": {"com.z": AxisError(np.nan)}}, "RMS error of com.z is nan"),
        ({"errors": {"com.z": AxisError(-1.0)}}, "RMS error of com.z is -1.0"),
        ({"circumstances": Circumstances({"P": [1.0, 2.0]})}, "P is .* for each of com.z"),
        ({"circumstances": Circumstances({"D": [np.inf]})}, "D is .* for each of com.z"),
    ],
)
def test_errors_and_gains_are_of_the_axes(changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(InvalidValue, match=expected):
        recording(**changes)
