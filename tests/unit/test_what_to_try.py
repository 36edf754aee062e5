from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from tsd_casadi.repetition.what_to_try import what_to_try

WENT_WELL: dict[str, Any] = {
    "fell": False,
    "failures": {},
    "at_limits": {},
    "steady": True,
    "laps_run": 3,
    "missed": {},
    "aborted": "",
    "feedforward": SimpleNamespace(kind="none"),
}


def tried(**changes: Any) -> list[str]:
    return what_to_try(SimpleNamespace(**{**WENT_WELL, **changes}))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"fell": True, "steady": False}, ["fall", "smaller or slower motion or a larger P"]),
        ({"failures": {"infeasible": 3}}, ["3 infeasible", "friction and limits"]),
        ({"at_limits": {"left_knee": 7}}, ["left_knee in 7 ticks", "another posture"]),
        ({"steady": False}, ["did not settle in 3 laps", "more laps"]),
        ({"missed": {"late": 4}}, ["slower pace"]),
    ],
)
def test_whatever_goes_wrong_has_a_remedy(changes: dict[str, Any], words: list[str]) -> None:
    (sentence,) = tried(**changes)
    for part in (*words, "try" if "at_limits" not in changes else "Try"):
        assert part in sentence


def test_a_fall_with_a_feedforward_may_be_its_fault() -> None:
    kind = SimpleNamespace(kind="generalised")
    (sentence,) = tried(fell=True, steady=False, feedforward=kind)
    assert "none of the generalised feedforward" in sentence


@pytest.mark.parametrize(
    "changes", [{}, {"missed": {"nothing there": 2}}, {"aborted": "lost", "steady": False}]
)
def test_nothing_is_said_of_what_went_well_or_was_ended(changes: dict[str, Any]) -> None:
    assert tried(**changes) == []
