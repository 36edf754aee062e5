from __future__ import annotations

import pytest

from tsd_casadi.exceptions import InvalidValue, UnknownField, UnknownRobot
from tsd_casadi.exceptions.did_you_mean import did_you_mean
from tsd_casadi.motions.squat import Squat

NAMES = ["amplitude", "frequency", "height", "com.P", "com.D"]


@pytest.mark.parametrize(
    ("name", "asked"),
    [
        ("heigth", "; did you mean 'height'?"),
        ("Frequency", "; did you mean 'frequency'?"),
        ("com.p", "; did you mean 'com.P'?"),
        ("com.I", "; did you mean 'com.P' or 'com.D'?"),
        ("speed", ""),
        ("", ""),
    ],
)
def test_names_that_resemble_are_asked_for(name: str, asked: str) -> None:
    assert sorted(did_you_mean(name, NAMES)) == sorted(asked)


def test_errors_show_it_beside_what_there_is() -> None:
    assert "did you mean 'com.P'?; there are com.P, com.D" in str(
        UnknownField("com.p", ["com.P", "com.D"])
    )
    assert str(UnknownRobot("hermes", ["hermes_lower"])).endswith("did you mean 'hermes_lower'?")
    with pytest.raises(InvalidValue, match=r"'speed'.*amplitude.*frequency.*default 0$"):
        Squat.declaration().complete({"speed": 1.0})
    with pytest.raises(InvalidValue, match=r"amplitude.*frequency.*did you mean 'frequency'\?$"):
        Squat.declaration().complete({"frequncy": 1.0})
