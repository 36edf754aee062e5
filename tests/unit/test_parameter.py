"""Parameters of motions, and what is said of a motion where its code is not."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi import Squat
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.motions.parameter import RESERVED

SQUAT = Squat.declaration()


def test_the_declaration_is_that_of_the_class() -> None:
    assert (SQUAT.motion, SQUAT.version) == (Squat.name, Squat.version)
    assert [item.name for item in SQUAT.parameters] == ["amplitude", "frequency", "height"]
    assert Squat(0.03).parameters == SQUAT.complete({"amplitude": 0.03})
    amplitude, frequency, height = SQUAT.parameters
    assert (amplitude.default, frequency.default, height.default) == (None, 0.25, 0.0)
    assert (amplitude.extent, height.place) == (True, True)


@pytest.mark.parametrize(
    ("name", "unit"), [("amplitude", "m"), ("frequency", "Hz"), ("height", "m"), ("depth", "")]
)
def test_units(name: str, unit: str) -> None:
    assert SQUAT.unit_of(name) == unit
    assert Declaration.unknown("bow").unit_of(name) == ""


@settings(max_examples=settings.default.max_examples // 3)
@given(amplitude=st.floats(0.0, 1e5), frequency=st.floats(0.01, 1e5), height=st.floats(-1e5, 1e5))
def test_what_makes_sense_is_taken_as_it_is(
    amplitude: float, frequency: float, height: float
) -> None:
    given = {"amplitude": amplitude, "frequency": frequency}
    assert SQUAT.complete(given) == {**given, "height": 0.0}
    given["height"] = height
    assert SQUAT.complete(given) == given


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"amplitude": -0.1}, "amplitude is -0.1, expected at least 0 m"),
        ({"frequency": 0.0}, "frequency is 0, expected at least 0.01 Hz"),
        ({"height": float("nan")}, "height is nan, expected a number in m below"),
        ({"amplitude": float("inf")}, "amplitude is inf, expected a number in m below"),
        ({"height": -1e7}, "height is -10000000.0, expected"),
        ({"depth": 1.0}, "'depth', expected amplitude .m.; frequency .Hz., default 0.25; height"),
        ({"heigth": 1.0}, "did you mean 'height'"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(changes: dict[str, float], message: str) -> None:
    with pytest.raises(InvalidValue, match=message):
        SQUAT.complete({"amplitude": 0.03, **changes})


@pytest.mark.parametrize("declaration", [SQUAT, Declaration.unknown("bow")])
@pytest.mark.parametrize("name", RESERVED)
def test_words_of_queries_are_no_parameters(declaration: Declaration, name: str) -> None:
    with pytest.raises(InvalidValue, match=f"parameter '{name}' is 1, expected another name"):
        declaration.complete({name: 1.0})


def test_what_is_missing_is_named() -> None:
    with pytest.raises(InvalidValue, match="the squat is without amplitude, expected all of ampl"):
        SQUAT.complete({"height": 0.1})


def test_a_motion_of_which_nothing_is_said_may_have_any_finite_parameters() -> None:
    bow = Declaration.unknown("bow")
    assert bow.complete({"depth": -1.0}) == {"depth": -1.0}
    with pytest.raises(InvalidValue, match="depth is nan"):
        bow.complete({"depth": float("nan")})
