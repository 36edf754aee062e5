from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.wire.feedforward import QuantityMessage
from tsd_casadi.wire.learner import DatabaseReply, EntryMessage
from tsd_clients.console import tables

SUMMARY: dict[str, Any] = {
    "label": "baseline",
    "rms_error_m": 1.23456e-3,
    "peak_error_m": 2.5e-3,
    "ac_rms_error_m": 3e-4,
    "true_rms_error_m": 4e-3,
    "mean_abs_feedback": 0.75037,
    "laps_measured": 2,
    "laps_run": 5,
    "tick_us": {"p50": 55.4, "p99": 124.0},
    "fell": False,
    "steady": True,
    "failures": {},
}


def an_entry(served: int) -> EntryMessage:
    errors = {"rms_error_m": 1.5e-3, "ac_rms_error_m": 2.5e-4}
    return EntryMessage(
        entry=42,
        robot="hermes_lower",
        task="squat",
        axes=("com.z",),
        parameters={
            "amplitude": QuantityMessage(value=0.03, unit="m"),
            "frequency": QuantityMessage(value=0.25, unit="Hz"),
        },
        served=served,
        learning_gain=1.0,
        rule="guarded",
        updated="2026-01-02T03:04:05+00:00",
        iterations=[(0, errors), (1, None)],
    )


def printed(show: Callable[[], None]) -> str:
    with tables.console.capture() as capture:
        show()
    return capture.get()


def test_runs_are_shown_in_millimetres() -> None:
    text = printed(lambda: tables.print_runs("squat", [SUMMARY]))
    for part in ("baseline", "1.2346", "2.5000", "0.3000", "4.0000", "0.75037", "2/5", "55", "124"):
        assert part in text
    assert "fell" not in text
    assert "steady" not in text


@pytest.mark.parametrize(
    ("changes", "remark"),
    [
        ({"fell": True, "steady": False}, "fell"),
        ({"steady": False}, "never steady"),
        ({"failures": {"infeasible": 3}}, "3 ticks infeasible"),
    ],
)
def test_what_went_wrong_is_said_beside_the_label(changes: dict[str, Any], remark: str) -> None:
    text = printed(lambda: tables.print_runs("squat", [{**SUMMARY, **changes}]))
    assert remark in " ".join(text.split())


def test_goals_say_whether_they_were_met() -> None:
    goals = [
        {"id": "one", "goal": "> 2", "measured": 3.0, "met": True},
        {"id": "two", "goal": "> 5", "measured": 4.0, "met": False},
        {"id": "three [min]", "goal": "< 5", "measured": None, "met": None},
    ]
    text = printed(lambda: tables.print_goals(goals)).splitlines()
    assert any("one" in line and "met" in line for line in text)
    assert any("two" in line and "missed" in line for line in text)
    assert any("three [min]" in line and "not covered" in line for line in text)


def test_entries_are_listed_with_units() -> None:
    reply = DatabaseReply(database="/tmp/d.sqlite", entries=[an_entry(0), an_entry(1)])
    text = " ".join(printed(lambda: tables.print_entries(reply)).split())
    for part in ("/tmp/d.sqlite", "42", "hermes_lower", "amplitude 0.03 m, frequency 0.25 Hz"):
        assert part in text


def test_entries_are_listed_with_what_is_served_and_how_good_it_is() -> None:
    reply = DatabaseReply(database="/tmp/d.sqlite", entries=[an_entry(0), an_entry(1)])
    text = " ".join(printed(lambda: tables.print_entries(reply)).split())
    for part in ("served", "1.5000", "0.2500", "untested"):
        assert part in text


def test_an_entry_of_somebodys_own_client_may_have_fewer_measures() -> None:
    entry = an_entry(0).model_copy(update={"iterations": [(0, {"rms_error_m": 1.5e-3}), (1, None)]})
    reply = DatabaseReply(database="/tmp/d.sqlite", entries=[entry])
    assert "1.5000" in printed(lambda: tables.print_entries(reply))


def test_places_are_shown_with_units_and_what_was_known_before() -> None:
    places = [
        {
            "parameters": {"amplitude": 0.05, "frequency": 0.4, "height": -0.01},
            "standard_deviation": None,
            "rms_errors_m": [],
        },
        {
            "parameters": {"amplitude": 0.08, "frequency": 0.6, "height": 0.0},
            "standard_deviation": 0.0123,
            "rms_errors_m": [0.015, 0.002, 0.0005],
        },
    ]
    lines = printed(lambda: tables.print_places("squat", places)).splitlines()
    (first,) = [" ".join(line.split()) for line in lines if "-0.01 m" in line]
    (second,) = [" ".join(line.split()) for line in lines if "0.08 m" in line]
    assert first == "1 amplitude 0.05 m, frequency 0.4 Hz, height -0.01 m - - -"
    assert second == "2 amplitude 0.08 m, frequency 0.6 Hz, height 0 m 0.0123 15.0000 0.5000"


def test_the_table_of_entries_fits_whole() -> None:
    parameters = {
        "amplitude": QuantityMessage(value=0.0365, unit="m"),
        "frequency": QuantityMessage(value=0.207, unit="Hz"),
        "height": QuantityMessage(value=-0.025, unit="m"),
    }
    entry = an_entry(0).model_copy(update={"parameters": parameters})
    reply = DatabaseReply(database="/tmp/d.sqlite", entries=[entry])
    text = printed(lambda: tables.print_entries(reply))
    assert "amplitude 0.0365 m, frequency 0.207 Hz, height -0.025 m" in text
    assert "…" not in text


def test_contraction_is_shown_by_harmonic() -> None:
    account = Contraction(
        axis="com.z",
        frequency=(0.0, 0.5, 1.0),
        plain=(0.0, 0.4, 1.2),
        predicted=(0.0, 0.1, None),
        observed=(0.02, None, 0.97),
        lead=0.012,
        bandwidth=0.5,
        gain=0.95,
        gain_deviation=0.04,
        delay=0.012,
        delay_deviation=0.003,
    )
    text = printed(lambda: tables.print_contractions("squat", {"amplitude": 0.03}, [account]))
    for part in ("com.z", "amplitude 0.03 m", "0.95 ± 0.04", "12.0 ± 3.0 ms", "bandwidth 0.5 Hz"):
        assert part in text
    rows = [line.split() for line in text.splitlines()]
    assert ["1", "0.5", "0.40", "0.10", "-"] in rows
    assert ["2", "1", "1.20", "-", "0.97"] in rows
