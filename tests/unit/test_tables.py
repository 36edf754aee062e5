from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.markup import escape

from tsd_casadi import Squat
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.context import NOWHERE
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.wire.axis import axis_messages, error_messages
from tsd_casadi.wire.context import ContextMessage
from tsd_casadi.wire.declaration import QuantityMessage, quantities
from tsd_casadi.wire.learner import (
    DamagedMessage,
    DatabaseReply,
    EntryMessage,
    IterationMessage,
)
from tsd_clients.console.examination_tables import print_examination
from tsd_clients.console.learner_tables import (
    describe_parameters,
    print_contractions,
    print_entries,
    print_places,
)
from tsd_clients.console.motion_tables import print_motion, print_motions
from tsd_clients.console.run_tables import print_accuracy, print_goals, print_runs
from tsd_clients.console.table import MOST_DRESSED, Column, console, plain_lines, print_table

SUMMARY: dict[str, Any] = {
    "label": "baseline",
    "errors": {
        "com.z": {
            "unit": "m",
            "rms": 1.23456e-3,
            "peak": 2.5e-3,
            "ac_rms": 3e-4,
            "true_rms": 4e-3,
            "mean_abs_feedback": 0.75037,
        }
    },
    "rank": 0.06,
    "laps_measured": 2,
    "laps_run": 5,
    "tick_us": {"p50": 55.4, "p99": 124.0},
    "fell": False,
    "fell_at": None,
    "steady": True,
    "failures": {},
    "missed": {},
    "aborted": None,
}
TURNED = {
    "unit": "rad",
    "rms": 7.5e-3,
    "peak": None,
    "ac_rms": None,
    "true_rms": None,
    "mean_abs_feedback": None,
}
TWO_AXES = {**SUMMARY, "errors": {**SUMMARY["errors"], "torso.rz": TURNED}}
SQUAT = Squat.declaration()


def an_entry(served: int, axes: tuple[str, ...] = ("com.z",)) -> EntryMessage:
    errors = error_messages({axis: AxisError(1.5e-3, ac_rms=2.5e-4) for axis in axes})
    return EntryMessage(
        entry=42,
        robot="hermes_lower",
        motion="squat",
        version="1",
        axes=axis_messages(axes),
        parameters=quantities(SQUAT, {"amplitude": 0.03, "frequency": 0.25}),
        context=ContextMessage(body="0123456789abcdef", formulation="fedcba9876543210"),
        served=served,
        learning_gain=1.0,
        rule="guarded",
        updated="2026-01-02T03:04:05+00:00",
        iterations=[IterationMessage(number=0, errors=errors), IterationMessage(number=1)],
    )


@contextmanager
def console_of(width: int) -> Iterator[None]:
    before, console.width = console.width, width
    try:
        yield
    finally:
        console.width = before


@pytest.fixture(autouse=True)
def wide() -> Iterator[None]:
    with console_of(140):
        yield


def printed(show: Callable[[], None]) -> str:
    with console.capture() as capture:
        show()
    return capture.get()


def test_runs_are_shown_in_millimetres() -> None:
    text = printed(lambda: print_runs("squat", [SUMMARY]))
    for part in ("baseline", "1.2346", "2.5000", "0.3000", "4.0000", "0.75037", "2/5", "55", "124"):
        assert part in text
    assert "fell" not in text
    assert "steady" not in text
    assert "rank" not in text  # of one axis it says nothing more


def test_each_axis_of_a_run_has_its_row_and_its_unit() -> None:
    text = printed(lambda: print_runs("twist", [TWO_AXES, SUMMARY])).splitlines()
    rows = [line.split() for line in text if "com.z" in line or "torso.rz" in line]
    assert [row[0] for row in rows] == ["baseline", "torso.rz", "baseline"]
    assert rows[1] == ["torso.rz", "7.5000", "-", "-", "-", "-"]
    assert rows[0][-1] == "0.06000"
    heading = " ".join(" ".join(text[:5]).split())
    assert "rank" in heading
    assert "mm, mrad" in heading
    assert "m/s², rad/s²" in heading


@pytest.mark.parametrize(
    ("changes", "remark"),
    [
        ({"fell": True, "fell_at": 1.5, "steady": False}, "fell"),
        ({"steady": False}, "never steady"),
        ({"failures": {"infeasible": 3}}, "3 ticks infeasible"),
        ({"missed": {"nothing there": 4}}, "4 periods missed, nothing there"),
        ({"aborted": "no torque"}, "aborted"),
    ],
)
def test_what_went_wrong_is_said_beside_the_label(changes: dict[str, Any], remark: str) -> None:
    text = printed(lambda: print_runs("squat", [{**SUMMARY, **changes}]))
    assert remark in " ".join(text.split())


FALLEN = {
    **SUMMARY,
    "fell": True,
    "fell_at": 1.234,
    "steady": False,
    "laps_measured": 0,
    "laps_run": 0,
    "errors": {"com.z": {**SUMMARY["errors"]["com.z"], "rms": None, "peak": None}},
}


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({}, "baseline: fell at t = 1.23 s, before a lap could be measured, every tick was solved"),
        (
            {"failures": {"infeasible": 12}, "missed": {"late": 3}},
            "fell at t = 1.23 s, before a lap could be measured, 12 infeasible ticks, 3 periods "
            "missed, late",
        ),
    ],
)
def test_a_fall_is_told_instead_of_a_table_of_dashes(changes: dict[str, Any], told: str) -> None:
    text = printed(lambda: print_runs("squat", [{**FALLEN, **changes}]))
    assert told in " ".join(text.split())
    assert "RMS" not in text


def test_a_fall_after_measured_laps_is_told_below_them() -> None:
    text = printed(lambda: print_runs("squat", [SUMMARY, {**FALLEN, "label": "learned"}]))
    assert "1.2346" in text
    assert text.splitlines()[-1].startswith("learned: fell at t = 1.23 s, before a lap")


def test_an_examination_names_joints_before_friction() -> None:
    part = {"value": 0.5, "of": "left_hip_pitch_joint"}
    names = ("joint", "torque", "friction")
    motion = {
        "motion": "squat",
        "parameters": {"amplitude": 0.03, "frequency": 0.25},
        "pressure": 0.04,
        **dict.fromkeys(names, part),
    }
    plain = {"motions": [motion], "findings": [], "works": True, "torque_speed": []}
    with console_of(80):
        text = printed(lambda: print_examination("mine", plain))
    heading, left_out = text.split("left_hip_pitch_joint", 1)[0], text.split("no room for")[-1]
    for part_of_heading in ("at 0.25 Hz", "to limit,", "rad", "inside", "feet, mm"):
        assert part_of_heading in heading
    assert "friction" in left_out
    assert "left_hip_pitch_joint" in text
    other = {**motion, "parameters": {"amplitude": 0.03, "frequency": 0.2}}
    text = printed(lambda: print_examination("mine", {**plain, "motions": [motion, other]}))
    assert "frequency=0.25" in text
    assert "frequency=0.2 " in text
    assert " Hz" not in text


def test_an_examination_shows_what_motors_have_left_at_speed() -> None:
    line = {
        "joint": "knee",
        "torque_limit": 139.0,
        "stall_torque": 260.0,
        "no_load_speed": 18.5,
        "full_torque_speed": 8.61,
        "velocity_limit": None,
    }
    plain: dict[str, Any] = {"motions": [], "findings": [], "works": True, "torque_speed": [line]}
    text = printed(lambda: print_examination("mine", plain))
    assert "left at speed" in text
    row = next(text_line for text_line in text.splitlines() if "knee" in text_line)
    assert row.split() == ["knee", "139", "8.61", "260", "18.5", "-"]
    assert "left at speed" not in printed(
        lambda: print_examination("mine", {**plain, "torque_speed": []})
    )


def test_goals_say_whether_they_were_met() -> None:
    goals = [
        {"id": "one", "goal": "> 2", "measured": 3.0, "met": True},
        {"id": "two", "goal": "> 5", "measured": 4.0, "met": False},
        {"id": "three [min]", "goal": "< 5", "measured": None, "met": None},
    ]
    text = printed(lambda: print_goals(goals)).splitlines()
    assert any("one" in line and "met" in line for line in text)
    assert any("two" in line and "missed" in line for line in text)
    assert any("three [min]" in line and "not covered" in line for line in text)


def test_entries_are_listed_with_units() -> None:
    reply = DatabaseReply(database="/tmp/d.sqlite", entries=[an_entry(0), an_entry(1)])
    text = " ".join(printed(lambda: print_entries(reply)).split())
    for part in ("/tmp/d.sqlite", "42 hermes_lower squat 0.03 0.25 com.z", "amplitude frequency"):
        assert part in text
    assert " m Hz " in text
    assert "012345 fedcba" in text
    assert "contexts" not in text
    assert describe_parameters(an_entry(0)) == "amplitude 0.03 m, frequency 0.25 Hz"


def test_entries_are_listed_with_what_is_served_and_how_good_it_is() -> None:
    reply = DatabaseReply(database="/tmp/d.sqlite", entries=[an_entry(0), an_entry(1)])
    text = " ".join(printed(lambda: print_entries(reply)).split())
    for part in ("served", "1.5000", "0.2500", "untested"):
        assert part in text


def test_an_entry_of_somebodys_own_client_may_have_fewer_measures() -> None:
    errors = error_messages({"com.z": AxisError(1.5e-3)})
    iterations = [IterationMessage(number=0, errors=errors), IterationMessage(number=1)]
    entry = an_entry(0).model_copy(update={"iterations": iterations})
    reply = DatabaseReply(database="/tmp/d.sqlite", entries=[entry])
    assert "1.5000" in printed(lambda: print_entries(reply))


def test_a_list_says_how_many_more_there_are() -> None:
    reply = DatabaseReply(database="d", entries=[an_entry(0)], more=960)
    assert "960 more that were recorded before: --limit" in printed(lambda: print_entries(reply))
    whole = DatabaseReply(database="d", entries=[an_entry(0)])
    assert "--limit" not in printed(lambda: print_entries(whole))


def test_entries_are_listed_with_epoch_correction_scatter_and_true_error_where_known() -> None:
    plain = an_entry(0)
    errors = error_messages({"com.z": AxisError(1.5e-3, true_rms=7.25e-3, scatter=0.0123)})
    known = plain.model_copy(
        update={
            "context": ContextMessage(body="0123", formulation="fedc", correction="c0ffee99"),
            "iterations": [IterationMessage(number=0, errors=errors, epoch=3)],
        }
    )
    text = printed(lambda: print_entries(DatabaseReply(database="d", entries=[plain, known])))
    (row,) = [line.split() for line in text.splitlines() if "c0ffee" in line]
    assert {"7.2500", "c0ffee", "3"} <= set(row)
    # a narrow terminal says what it has no room for
    assert "0.0123" in row or "repeats to m/s²" in text
    assert "true RMS" not in printed(
        lambda: print_entries(DatabaseReply(database="d", entries=[plain]))
    )


CELL = st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), max_size=5)


@given(st.lists(st.tuples(CELL, CELL), min_size=1, max_size=4))
def test_a_long_table_looks_as_rich_would_lay_it_out(cells: list[tuple[str, str]]) -> None:
    left, right = ([escape(each) for each in column] for column in zip(*cells, strict=True))
    columns = [Column("a\nm", right), Column("b", left, is_text=True), Column("c", right)]
    dressed = printed(lambda: print_table("", columns)).splitlines()
    assert plain_lines(columns) == [line.rstrip() for line in dressed[1:]]


def test_many_rows_are_printed_plainly(monkeypatch: pytest.MonkeyPatch) -> None:
    columns = [Column("a", ["1"] * (MOST_DRESSED + 1))]
    dressed = printed(lambda: print_table("", columns)).splitlines()
    monkeypatch.delattr("tsd_clients.console.table.Table")
    plain = printed(lambda: print_table("", columns)).splitlines()
    assert [line.rstrip() for line in plain] == [line.rstrip() for line in dressed]


def test_places_are_shown_with_units_and_what_was_known_before() -> None:
    places = [
        {
            "parameters": {"amplitude": 0.05, "frequency": 0.4, "height": -0.01},
            "standard_deviation": None,
            "errors": [],
        },
        {
            "parameters": {"amplitude": 0.08, "frequency": 0.6, "height": 0.0},
            "standard_deviation": 0.0123,
            "errors": [{"com.z": {"rms": rms, "unit": "m"}} for rms in (0.015, 0.002, 0.0005)],
        },
    ]
    lines = printed(lambda: print_places(SQUAT, places)).splitlines()
    (first,) = [" ".join(line.split()) for line in lines if "-0.01" in line]
    (second,) = [" ".join(line.split()) for line in lines if "0.08" in line]
    assert first == "1 0.05 0.4 -0.01 - - - -"
    assert second == "2 0.08 0.6 0 com.z 0.0123 15.0000 0.5000"


def test_a_parameter_that_a_motion_has_not_stays_empty() -> None:
    depth = QuantityMessage(value=0.5, unit="")
    other = an_entry(0).model_copy(update={"motion": "bow", "parameters": {"depth": depth}})
    reply = DatabaseReply(database="d", entries=[an_entry(0), other])
    lines = printed(lambda: print_entries(reply)).splitlines()
    heading, *rows = [line for line in lines if "depth" in line or "hermes" in line]
    assert heading.split()[3:6] == ["m", "Hz", "depth"]
    assert [row.split()[3:5] for row in rows] == [["0.03", "0.25"], ["0.5", "com.z"]]


def test_an_entry_has_a_row_for_each_axis() -> None:
    reply = DatabaseReply(database="d", entries=[an_entry(0, ("com.z", "torso.rz"))])
    lines = printed(lambda: print_entries(reply)).splitlines()
    rows = [line.split() for line in lines if "com.z" in line or "torso.rz" in line]
    assert rows[0][:2] == ["42", "hermes_lower"]
    assert rows[1] == ["torso.rz", "1.5000", "0.2500"]


def test_other_contexts_are_counted_and_what_is_unknown_or_damaged_is_said() -> None:
    other = an_entry(0).model_copy(update={"context": ContextMessage.of(NOWHERE)})
    damaged = (DamagedMessage(entry=7, reason="its checksum is wrong"),)
    reply = DatabaseReply(database="d", entries=[an_entry(0), other], damaged=damaged)
    text = " ".join(printed(lambda: print_entries(reply)).split())
    assert "unknown" in text
    assert "2 entries of 2 contexts" in text
    assert "entry 7 cannot be read: its checksum is wrong" in text


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
    text = printed(lambda: print_contractions(SQUAT, {"amplitude": 0.03}, [account]))
    for part in ("com.z", "amplitude 0.03 m", "0.95 ± 0.04", "12.0 ± 3.0 ms", "bandwidth 0.5 Hz"):
        assert part in text
    # the prediction is exceeded by loops that are not linear
    assert "if linear" in text
    assert "at most" not in text
    rows = [line.split() for line in text.splitlines()]
    assert ["1", "0.5", "0.40", "0.10", "-"] in rows
    assert ["2", "1", "1.20", "-", "0.97"] in rows


COLUMNS = [
    Column("name", ["one", "two words"], is_text=True),
    Column("least", ["1", "2"], rank=9),
    Column("number\nm", ["1.25", "2.5"]),
    Column("more", ["3", "4"], rank=1),
]


def test_where_there_is_room_every_column_is_shown() -> None:
    text = printed(lambda: print_table("title", COLUMNS))
    assert [line.split() for line in text.splitlines()[-2:]] == [
        ["one", "1", "1.25", "3"],
        ["two", "words", "2", "2.5", "4"],
    ]
    assert "no room" not in text


@pytest.mark.parametrize(
    ("width", "left_out"), [(26, "least"), (20, "least, more"), (12, "least, more")]
)
def test_where_it_is_narrow_what_matters_least_goes_first_and_is_named(
    width: int, left_out: str
) -> None:
    with console_of(width):
        lines = printed(lambda: print_table("", COLUMNS)).splitlines()
    assert all(len(line) <= width for line in lines)
    assert f"no room for {left_out}:" in " ".join(" ".join(lines).split())
    assert any("1.25" in line for line in lines)


@pytest.mark.parametrize(
    "show", ["runs", "axes", "motions", "motion", "entries", "goals", "accuracy", "places"]
)
def test_tables_fit_eighty_columns_without_breaking_a_cell(show: str) -> None:
    label = "squat 3 cm, learned, iteration 10, P x 0.2, hardware"
    parameters = {
        "amplitude": QuantityMessage(value=0.0365, unit="m"),
        "frequency": QuantityMessage(value=0.207, unit="Hz"),
        "height": QuantityMessage(value=-0.025, unit="m"),
    }
    entry = an_entry(0).model_copy(update={"parameters": parameters})
    goal = {"id": "AC error, generalised / learned directly", "goal": "<= 1.5", "met": True}
    place = {
        "parameters": {name: quantity.value for name, quantity in parameters.items()},
        "standard_deviation": 0.0123,
        "errors": [{"com.z": {"rms": rms, "unit": "m"}} for rms in (0.015, 0.0005)],
    }
    squat = {
        "name": "squat",
        "version": "1",
        "meaning": "A squat",
        "robot": "hermes_lower",
        "axes": ["com.z"],
        "usual_axes": ["com.z", "com.x", "com.y"],
        "parameters": [vars(item) for item in SQUAT.parameters],
    }
    accuracy = {
        "poses": 30,
        "cop_residual_before": 1e-3,
        "cop_residual_after": 1e-4,
        "error_before": [0.01] * 3,
        "error_after": [0.001] * 3,
        "deviation_before": [0.01] * 3,
        "deviation_after": [0.001] * 3,
    }
    tables: dict[str, tuple[Callable[[], None], str]] = {
        "runs": (lambda: print_runs("squat", [{**SUMMARY, "label": label}]), label),
        "axes": (lambda: print_runs("squat", [{**TWO_AXES, "label": label}]), label),
        "motions": (lambda: print_motions([squat]), "amplitude"),
        "motion": (lambda: print_motion(squat), "amplitude"),
        "entries": (
            lambda: print_entries(DatabaseReply(database="/tmp/d.sqlite", entries=[entry])),
            "0.0365",
        ),
        "goals": (lambda: print_goals([{**goal, "measured": 1.23456}]), str(goal["id"])),
        "accuracy": (lambda: print_accuracy("com.json", accuracy), "its height at home"),
        "places": (lambda: print_places(SQUAT, [place]), "0.0365"),
    }
    show_it, whole = tables[show]
    with console_of(80):
        text = printed(show_it)
    assert all(len(line) <= 80 for line in text.splitlines())
    assert "…" not in text
    assert whole in text
