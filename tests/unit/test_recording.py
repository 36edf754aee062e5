from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.recording import Context, Recording, TaskKey

BASIS = PeriodicBasis()
PHASE = np.linspace(0, 2 * np.pi, 100, endpoint=False)
WAVE = np.sin(PHASE)[None, :]
BARE, WHOLE = Lap(PHASE, WAVE), Lap(PHASE, WAVE, WAVE / 100, WAVE / 20)
CONTEXT = Context("00ff", "abcd", {"P": [50.0], "D": [14.0]}, "0.1.0")


def recording(**changes: Any) -> Recording:
    made = Recording(
        key=TaskKey.of("r", "squat", ("com.z",), {"amplitude": 0.03, "frequency": 0.25}),
        basis=BASIS,
        applied=np.zeros((1, BASIS.L)),
        laps=[WHOLE],
        errors={"rms_error_m": 1e-3},
        context=CONTEXT,
    )
    return replace(made, **changes)


@pytest.mark.parametrize("rule", ["plain", "guarded", "stable"])
def test_whole_laps_do_for_every_rule(rule: str) -> None:
    assert recording(rule=rule).rule == rule


@pytest.mark.parametrize("rule", ["plain", "guarded"])
def test_the_sum_needs_neither_errors_nor_frequency_nor_gains(rule: str) -> None:
    key = TaskKey.of("r", "jump", ("com.z",), {"depth": 1.0})
    recording(rule=rule, laps=[BARE], key=key, context=replace(CONTEXT, gains={}))


@pytest.mark.parametrize("laps", [[BARE], [WHOLE, BARE], [replace(WHOLE, reference=None)]])
def test_the_stable_rule_asks_for_errors_and_references(laps: list[Lap]) -> None:
    with pytest.raises(InvalidValue, match=r"laps.*error and reference.*or another rule"):
        recording(rule="stable", laps=laps)


@pytest.mark.parametrize("gains", [{}, {"P": [50.0]}, {"P": [0.0], "D": [14.0]}])
def test_the_stable_rule_asks_for_gains(gains: dict[str, list[float]]) -> None:
    with pytest.raises(InvalidValue, match=r"frequency, P and D.*com\.z a positive P"):
        recording(rule="stable", context=replace(CONTEXT, gains=gains))


def test_the_stable_rule_asks_for_a_frequency() -> None:
    key = TaskKey.of("r", "jump", ("com.z",), {"depth": 1.0})
    with pytest.raises(InvalidValue, match=r"None, \[50\.0\] and \[14\.0\]"):
        recording(rule="stable", key=key)


def test_a_recording_without_laps_is_refused() -> None:
    with pytest.raises(InvalidValue, match="laps is none"):
        recording(laps=[])


@pytest.mark.parametrize("name", ["phase", "feedback", "error", "reference"])
def test_numbers_that_are_not_finite_are_refused(name: str) -> None:
    spoilt = getattr(WHOLE, name).copy()
    spoilt[..., 3] = np.nan
    with pytest.raises(InvalidValue, match="lap 1 is not finite"):
        recording(laps=[WHOLE, replace(WHOLE, **{name: spoilt})])
