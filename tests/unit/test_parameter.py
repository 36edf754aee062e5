from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi import Squat
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.parameter import (
    MOTION_PARAMETERS,
    complete_parameters,
    default_parameters,
    unit_of,
)

POSITIVE = st.floats(1e-3, 1e5)


def test_the_table_has_the_parameters_of_the_motions() -> None:
    squat = Squat(0.03, 0.25)
    assert {item.name for item in MOTION_PARAMETERS[squat.name]} == squat.parameters.keys()
    assert default_parameters(squat.name) == {"height": squat.height}


@pytest.mark.parametrize(
    ("name", "unit"), [("amplitude", "m"), ("frequency", "Hz"), ("height", "m"), ("depth", "")]
)
def test_units(name: str, unit: str) -> None:
    assert unit_of("squat", name) == unit
    assert unit_of("bow", name) == ""


@settings(max_examples=settings.default.max_examples // 3)
@given(amplitude=POSITIVE, frequency=POSITIVE, height=st.floats(-1e5, 1e5))
def test_what_makes_sense_is_taken_as_it_is(
    amplitude: float, frequency: float, height: float
) -> None:
    given = {"amplitude": amplitude, "frequency": frequency}
    assert complete_parameters("squat", given) == {**given, "height": 0.0}
    given["height"] = height
    assert complete_parameters("squat", given) == given


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"amplitude": 0.0}, "amplitude is 0.0, expected a positive number in m"),
        ({"frequency": -1.0}, "frequency is -1.0, expected a positive number in Hz"),
        ({"height": float("nan")}, "height is nan, expected a number in m below"),
        ({"amplitude": float("inf")}, "amplitude is inf, expected a number in m below"),
        ({"height": -1e7}, "height is -10000000.0, expected"),
        ({"depth": 1.0}, "'depth', expected amplitude .m.; frequency .Hz.; height .m., default 0"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(changes: dict[str, float], message: str) -> None:
    with pytest.raises(InvalidValue, match=message):
        complete_parameters("squat", {"amplitude": 0.03, "frequency": 0.25, **changes})


@pytest.mark.parametrize("motion", ["squat", "bow"])
def test_words_of_queries_are_no_parameters(motion: str) -> None:
    with pytest.raises(InvalidValue, match="parameter 'kind' is 1, expected another name"):
        complete_parameters(motion, {"kind": 1.0})


def test_what_is_missing_is_named() -> None:
    with pytest.raises(InvalidValue, match="without amplitude and without frequency"):
        complete_parameters("squat", {"height": 0.1})


def test_a_motion_of_somebodys_own_may_have_any_finite_parameters() -> None:
    assert complete_parameters("bow", {"depth": -1.0}) == {"depth": -1.0}
    with pytest.raises(InvalidValue, match="depth is nan"):
        complete_parameters("bow", {"depth": float("nan")})
