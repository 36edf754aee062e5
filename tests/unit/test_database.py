from __future__ import annotations

import json
import os
import signal
import sqlite3
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tsd_casadi.database.database_file
from tsd_casadi.database.database import Database, default_path
from tsd_casadi.database.schema import APPLICATION_ID, SCHEMA, SCHEMA_VERSION
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import (
    DatabaseError,
    EntryNotFound,
    IncompatibleEntry,
    InvalidValue,
    OutsideTrainedRange,
    TsdError,
)
from tsd_casadi.generalization.weight_regression import WeightRegression
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Context, Recording
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.motions.parameter import MOTION_PARAMETERS, RESERVED

BASIS = PeriodicBasis()
CONTEXT = Context("00ff", "abcd", {"P": [50.0], "D": [14.0]}, "0.1.0")
PHASE = np.pi + np.linspace(0, 2 * np.pi, 100, endpoint=False)
AMPLITUDES = (0.02, 0.04, 0.06, 0.08)
SQUAT = {"amplitude": 0.03, "frequency": 0.25}
# what a test leaves in its iteration besides errors and gains
FITTED = ("feedback", "error_weights", "reference_weights")


def recording(
    amplitude: float = 0.03,
    frequency: float = 0.25,
    *,
    robot: str = "hermes_lower",
    axes: tuple[str, ...] = ("com.z",),
    error: float = 1e-3,
    **changes: Any,
) -> Recording:
    """A repetition without feedforward; what it needed grows with amplitude and frequency."""
    feedback = 0.7 + 30 * amplitude**2 + amplitude * np.sin(PHASE)
    feedback = feedback + 0.2 * frequency**2 * np.cos(PHASE)
    made = Recording(
        key=EntryKey.of(robot, "squat", axes, {"amplitude": amplitude, "frequency": frequency}),
        basis=BASIS,
        applied=np.zeros((len(axes), BASIS.L)),
        laps=[Lap(PHASE, np.tile(feedback, (len(axes), 1)))] * 2,
        errors={"rms_error_m": error},
        context=CONTEXT,
    )
    return replace(made, **changes)


def told(rule: str = "guarded", **changes: bool) -> Instruction:
    return Instruction(find_rule(rule), **changes)


def assert_same(one: Entry, other: Entry) -> None:
    assert (one.key, one.basis, one.context) == (other.key, other.basis, other.context)
    assert (one.learning_gain, one.rule) == (other.learning_gain, other.rule)
    assert (one.identifier, one.updated) == (other.identifier, other.updated)
    assert len(one.iterations) == len(other.iterations)
    for a, b in zip(one.iterations, other.iterations, strict=True):
        assert (a.number, a.errors) == (b.number, b.errors)
        assert a.learned_from == b.learned_from
        np.testing.assert_array_equal(a.weights, b.weights)
        for name in FITTED:
            fitted, expected = getattr(a, name), getattr(b, name)
            assert (fitted is None) == (expected is None)
            if fitted is not None:
                np.testing.assert_array_equal(fitted, expected)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "squat.sqlite"


@pytest.fixture
def database(path: Path) -> Any:
    with Database(path) as opened:
        yield opened


@pytest.fixture(scope="module")
def trained_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four amplitudes at 0.25 Hz, one at 0.5 Hz."""
    path = tmp_path_factory.mktemp("trained") / "squat.sqlite"
    with Database(path) as database:
        for amplitude in AMPLITUDES:
            database.record(recording(amplitude))
        database.record(recording(0.05, 0.5))
    return path


@pytest.fixture
def trained(trained_path: Path) -> Any:
    """Only to be queried."""
    with Database(trained_path) as opened:
        yield opened


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Locks are waited for 50 ms instead of 5 s."""
    monkeypatch.setattr(
        tsd_casadi.database.database_file.sqlite3, "connect", partial(sqlite3.connect, timeout=0.05)
    )


# record, reopen, forget


def test_record_makes_an_entry_that_is_served(database: Database) -> None:
    entry, notes = database.record(recording())
    assert (entry.identifier, entry.served.number, notes) == (1, 1, [])
    feedforward = database.query("squat", amplitude=0.03, frequency=0.25)
    assert (feedforward.kind, feedforward.iteration) == ("learned", 1)
    np.testing.assert_array_equal(feedforward.weights, entry.served.weights)
    assert feedforward.provenance["entries"] == [1]


def test_everything_survives_reopening(path: Path) -> None:
    with Database(path) as database:
        entry, _ = database.record(recording())
        applied = entry.served.weights
        entry, _ = database.record(recording(applied=applied, error=2e-3), told("guarded"))
        database.record(recording(0.05, axes=("com.x", "com.z")), told("plain"))
        before = database.entries()
    with Database(path) as database:
        after = database.entries()
    assert len(after) == 2
    assert after[0].learning_gain == 0.5
    assert after[1].rule.name == "plain"
    for one, other in zip(before, after, strict=True):
        assert_same(one, other)
    assert_same(entry, after[0])


NUMBERS = st.floats(allow_nan=False, allow_infinity=False, width=64)
NAMES = st.text(min_size=1, max_size=20).filter(lambda text: "\x00" not in text)
PARAMETERS = NAMES.filter(lambda name: name not in RESERVED)


@settings(max_examples=settings.default.max_examples // 3)
@given(data=st.data())
def test_any_entry_comes_back_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    size = data.draw(st.integers(1, 6), "L")
    axes = tuple(data.draw(st.lists(NAMES, min_size=1, max_size=3, unique=True), "axes"))
    weights = st.lists(st.floats(-1e12, 1e12), min_size=size * len(axes), max_size=size * len(axes))
    applied = np.array(data.draw(weights, "applied")).reshape(len(axes), size)
    made = Recording(
        key=EntryKey.of(
            data.draw(NAMES, "robot"),
            data.draw(NAMES.filter(lambda name: name not in MOTION_PARAMETERS), "motion"),
            axes,
            data.draw(st.dictionaries(PARAMETERS, st.floats(-1e5, 1e5), max_size=3), "parameters"),
        ),
        basis=PeriodicBasis(size, data.draw(st.floats(0.1, 1e5), "width")),
        applied=applied,
        laps=[Lap(PHASE, np.ones((len(axes), 100)))] * 2,
        errors={"rms_error_m": data.draw(st.floats(0, 1e3)), "other": data.draw(NUMBERS)},
        context=Context(
            data.draw(NAMES), data.draw(NAMES), {"P": [data.draw(NUMBERS)]}, data.draw(NAMES)
        ),
    )
    path = tmp_path_factory.mktemp("any") / "d.sqlite"
    with Database(path) as database:
        rule = data.draw(st.sampled_from(["guarded", "plain"]))
        stored, _ = database.record(made, told(rule, update=data.draw(st.booleans())))
    with Database(path) as database:
        (found,) = database.entries()
    assert_same(stored, found)
    assert found.key == made.key
    assert any(np.allclose(applied, i.weights, rtol=0, atol=1e-12) for i in found.iterations)


def test_iterations_go_on_after_reopening(path: Path) -> None:
    for error, number in ((3e-3, 1), (2e-3, 2), (1e-3, 3)):
        with Database(path) as database:
            entries = database.entries()
            applied = entries[0].served.weights if entries else np.zeros((1, BASIS.L))
            entry, _ = database.record(recording(applied=applied, error=error))
            assert entry.served.number == number
            assert [i.errors is None for i in entry.iterations] == [False] * number + [True]


def test_never_worse_rule_survives_reopening(path: Path) -> None:
    with Database(path) as database:
        entry, _ = database.record(recording(error=1e-3))
    with Database(path) as database:
        _, notes = database.record(recording(applied=entry.served.weights, error=2e-3))
        assert len(notes) == 1
    with Database(path) as database:
        served = database.query("squat", amplitude=0.03, frequency=0.25)
        assert served.iteration == 0
        assert not served.weights.any()
        assert database.entries()[0].learning_gain == 0.5


def test_parameters_are_the_same_to_1e_6(database: Database) -> None:
    database.record(recording(0.03))
    database.record(recording(0.03 + 4e-7, error=0.5e-3))
    (entry,) = database.entries()
    assert entry.key.parameters == (("amplitude", 0.03), ("frequency", 0.25), ("height", 0.0))
    assert database.query("squat", amplitude=0.03 - 4e-7, frequency=0.25).kind == "learned"
    database.record(recording(0.030002))
    assert len(database.entries()) == 2


def test_entries_are_told_apart_by_robot_task_axes_and_parameters(database: Database) -> None:
    first = recording()
    others = [
        recording(robot="mini"),
        recording(axes=("com.x",)),
        recording(0.04),
        recording(frequency=0.5),
        replace(first, key=replace(first.key, motion="sway")),
    ]
    identifiers = {database.record(made)[0].identifier for made in (first, *others)}
    assert identifiers == {1, 2, 3, 4, 5, 6}
    assert [entry.identifier for entry in database.entries("mini")] == [2]
    assert [entry.identifier for entry in database.entries(motion="sway")] == [6]
    assert database.entries("mini", "sway") == []


def test_restart_forgets_only_that_entry(database: Database) -> None:
    entry, _ = database.record(recording())
    database.record(recording(applied=entry.served.weights, error=2e-3))
    other, _ = database.record(recording(0.05))
    again, notes = database.record(recording(error=5e-3), told(restart=True))
    assert notes == []
    assert again.identifier not in (entry.identifier, other.identifier)
    assert (again.learning_gain, [i.number for i in again.iterations]) == (1.0, [0, 1])
    assert [e.identifier for e in database.entries()] == [other.identifier, again.identifier]


def test_restart_accepts_another_basis_and_formulation(database: Database) -> None:
    database.record(recording())
    other = PeriodicBasis.of_size(10)
    made = recording(
        basis=other,
        applied=np.zeros((1, 10)),
        context=replace(CONTEXT, formulation="beef"),
    )
    with pytest.raises(IncompatibleEntry):
        database.record(made)
    database.record(made, told(restart=True))
    (entry,) = database.entries()
    assert (entry.basis, entry.context.formulation) == (other, "beef")


def test_a_restart_that_fails_forgets_nothing(database: Database) -> None:
    before, _ = database.record(recording())
    with pytest.raises(InvalidValue, match="without error and reference"):
        database.record(recording(), told("stable", restart=True))
    (after,) = database.entries()
    assert_same(before, after)


def test_a_refused_recording_leaves_the_entry_alone(database: Database) -> None:
    before, _ = database.record(recording())
    with pytest.raises(IncompatibleEntry):
        database.record(recording(context=replace(CONTEXT, formulation="beef")), told("plain"))
    (after,) = database.entries()
    assert_same(before, after)


def test_forget_removes_entry_and_iterations(path: Path, database: Database) -> None:
    database.record(recording())
    kept, _ = database.record(recording(0.05))
    gone = database.forget(1)
    assert gone.key.parameters[0] == ("amplitude", 0.03)
    assert [entry.identifier for entry in database.entries()] == [kept.identifier]
    with closing(sqlite3.connect(path)) as plain:
        assert plain.execute("SELECT DISTINCT entry FROM iteration").fetchall() == [(2,)]
    with pytest.raises(EntryNotFound, match="no entry 1"):
        database.forget(1)


def test_numbers_of_forgotten_entries_are_not_used_again(database: Database) -> None:
    database.record(recording())
    database.forget(1)
    assert database.record(recording())[0].identifier == 2


def test_the_file_is_plain_numbers_for_any_tool(path: Path, database: Database) -> None:
    entry, _ = database.record(recording())
    with closing(sqlite3.connect(path)) as plain:
        ((weights,),) = plain.execute("SELECT weights FROM iteration WHERE number = 1").fetchall()
        ((parameters,),) = plain.execute("SELECT parameters FROM entry").fetchall()
    np.testing.assert_array_equal(json.loads(weights), entry.served.weights)
    assert json.loads(parameters) == {"amplitude": 0.03, "frequency": 0.25, "height": 0.0}
    assert b"pickle" not in path.read_bytes()


# learned and generalised queries


def test_learned_means_the_exact_entry(trained: Database) -> None:
    for kind in (None, "learned"):
        feedforward = trained.query("squat", kind=kind, amplitude=0.04, frequency=0.25)
        assert (feedforward.kind, feedforward.provenance["entries"]) == ("learned", [2])


@pytest.mark.parametrize(
    ("amplitude", "frequency"), [(0.05, 0.25), (0.04, 0.5), (0.09, 0.25), (0.040002, 0.25)]
)
def test_learned_fails_without_the_exact_entry(
    trained: Database, amplitude: float, frequency: float
) -> None:
    with pytest.raises(EntryNotFound, match="no entry for squat") as caught:
        trained.query("squat", kind="learned", amplitude=amplitude, frequency=frequency)
    assert "amplitude=0.08" in str(caught.value)  # what there is


def test_without_an_exact_entry_the_answer_is_generalised(trained: Database) -> None:
    feedforward = trained.query("squat", amplitude=0.05, frequency=0.25)
    assert feedforward.kind == "generalised"
    assert feedforward.parameters == {"amplitude": 0.05, "frequency": 0.25, "height": 0.0}
    assert (feedforward.std(PHASE) > 0).all()


def regression_over(entries: list[Entry], *names: str) -> WeightRegression:
    inputs = np.array([[dict(entry.key.parameters)[name] for name in names] for entry in entries])
    return WeightRegression("squat", names, inputs, [e.served.weights for e in entries], BASIS)


def test_generalised_is_the_regression_over_what_differs(trained: Database) -> None:
    wanted = {"amplitude": 0.05, "frequency": 0.3}
    mean, std = regression_over(trained.entries(), "amplitude", "frequency").predict(wanted)
    feedforward = trained.query("squat", **wanted)
    np.testing.assert_allclose(feedforward.weights, mean, atol=1e-12)
    np.testing.assert_allclose(feedforward.standard_deviations, std, atol=1e-12)
    assert feedforward.provenance["entries"] == [1, 2, 3, 4, 5]
    assert feedforward.provenance["parameters"] == [
        {"amplitude": amplitude, "frequency": frequency, "height": 0.0}
        for amplitude, frequency in [*((a, 0.25) for a in AMPLITUDES), (0.05, 0.5)]
    ]
    assert feedforward.provenance["length_scales"].keys() == {"amplitude", "frequency"}
    assert len(feedforward.provenance["calibration"]["residuals"]) == 5


def test_generalised_excludes_the_exact_entry(trained: Database) -> None:
    found = trained.query("squat", kind="generalised", amplitude=0.04, frequency=0.25)
    assert found.kind == "generalised"
    assert found.provenance["entries"] == [1, 3, 4, 5]
    entries = {entry.identifier: entry for entry in trained.entries()}
    used = [entries[number] for number in (1, 3, 4, 5)]
    mean, std = regression_over(used, "amplitude", "frequency").predict(
        {"amplitude": 0.04, "frequency": 0.25}
    )
    np.testing.assert_allclose(found.weights, mean, atol=1e-12)
    np.testing.assert_allclose(found.standard_deviations, std, atol=1e-12)
    assert np.abs(found.weights - entries[2].served.weights).max() > 1e-9


def test_generalised_at_the_end_of_the_range_would_be_an_extrapolation(trained: Database) -> None:
    with pytest.raises(OutsideTrainedRange, match=r"0\.02 to 0\.06 m"):
        trained.query("squat", kind="generalised", amplitude=0.08, frequency=0.25)


@pytest.mark.parametrize("amplitude", [0.01, 0.09])
def test_outside_the_trained_range_is_refused_unless_asked_for(
    trained: Database, amplitude: float
) -> None:
    with pytest.raises(OutsideTrainedRange):
        trained.query("squat", amplitude=amplitude, frequency=0.25)
    found = trained.query("squat", amplitude=amplitude, frequency=0.25, extrapolate=True)
    assert found.kind == "generalised"
    assert np.isfinite(found.weights).all()


def test_one_other_entry_is_too_few(database: Database) -> None:
    database.record(recording(0.02))
    with pytest.raises(EntryNotFound, match="at least 2"):
        database.query("squat", amplitude=0.03, frequency=0.25)


@pytest.mark.parametrize("kind", [None, "learned", "generalised"])
def test_an_empty_database_says_so(database: Database, kind: str | None) -> None:
    with pytest.raises(EntryNotFound, match="nothing yet"):
        database.query("squat", kind=kind, amplitude=0.03, frequency=0.25)


def test_what_no_entry_varies_cannot_be_generalised_over(database: Database) -> None:
    for amplitude in (0.02, 0.04):
        database.record(recording(amplitude, 0.5))
    with pytest.raises(EntryNotFound, match=r"frequency 0\.5 Hz, none.*to 0\.25 Hz"):
        database.query("squat", amplitude=0.03, frequency=0.25, extrapolate=True)
    with pytest.raises(EntryNotFound, match=r"height 0 m, none.*to -0\.01 m"):
        database.query("squat", amplitude=0.03, frequency=0.5, height=-0.01)
    assert database.query("squat", amplitude=0.03, frequency=0.5).kind == "generalised"


def test_each_parameter_has_a_range_of_its_own(trained: Database) -> None:
    with pytest.raises(OutsideTrainedRange, match=r"0\.25 to 0\.5 Hz") as caught:
        trained.query("squat", amplitude=0.05, frequency=0.6)
    assert caught.value.parameter == "frequency"
    found = trained.query("squat", amplitude=0.05, frequency=0.6, extrapolate=True)
    assert np.isfinite(found.weights).all()


def test_too_few_entries_for_so_many_parameters_are_refused(database: Database) -> None:
    database.record(recording(0.02, 0.25))
    database.record(recording(0.04, 0.5))
    with pytest.raises(EntryNotFound, match="amplitude and frequency needs at least 3"):
        database.query("squat", amplitude=0.03, frequency=0.3)


def test_height_is_zero_where_nothing_is_said(database: Database) -> None:
    database.record(recording())
    squat = {"amplitude": 0.03, "frequency": 0.25, "height": 0.0}
    key = EntryKey.of("hermes_lower", "squat", ("com.z",), squat)
    (entry,) = database.entries()
    assert entry.key == key
    database.record(recording(key=key, applied=entry.served.weights, error=0.5e-3))
    assert len(database.entries()) == 1
    for height in ({}, {"height": 0.0}, {"height": -0.0}):
        found = database.query("squat", amplitude=0.03, frequency=0.25, **height)
        assert (found.kind, found.iteration) == ("learned", 2)


def test_squats_below_home_are_other_entries_to_generalise_over(database: Database) -> None:
    for height in (-0.02, 0.0, 0.02):
        key = EntryKey.of("hermes_lower", "squat", ("com.z",), {**SQUAT, "height": height})
        database.record(recording(key=key))
    assert len(database.entries()) == 3
    between = database.query("squat", **SQUAT, height=-0.01)
    assert between.kind == "generalised"
    assert between.provenance["length_scales"].keys() == {"height"}
    with pytest.raises(OutsideTrainedRange, match=r"height -0\.03 m.*-0\.02 to 0\.02 m"):
        database.query("squat", **SQUAT, height=-0.03)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"amplitude": 0.0}, "amplitude is 0.0"),
        ({"frequency": -0.25}, "frequency is -0.25"),
        ({"frequency": float("nan")}, "frequency is nan"),
        ({"height": float("inf")}, "height is inf"),
        ({"colour": 1.0}, "'colour'"),
    ],
)
def test_parameters_that_make_no_sense_are_refused(
    database: Database, changes: dict[str, float], named: str
) -> None:
    parameters = {**SQUAT, **changes}
    key = replace(recording().key, parameters=tuple(parameters.items()))
    with pytest.raises(InvalidValue, match=named):
        database.record(recording(key=key))
    with pytest.raises(InvalidValue, match=named):
        database.query("squat", **parameters)
    assert database.entries() == []


def test_a_recording_without_frequency_is_refused(database: Database) -> None:
    key = replace(recording().key, parameters=(("amplitude", 0.03),))
    with pytest.raises(InvalidValue, match="without frequency"):
        database.record(recording(key=key))


def test_motions_of_somebodys_own_have_parameters_as_they_come(database: Database) -> None:
    for depth in (1.0, 2.0):
        key = EntryKey.of("hermes_lower", "bow", ("com.z",), {"depth": depth})
        database.record(recording(key=key))
    assert database.query("bow", depth=1.0).kind == "learned"
    assert database.query("bow", depth=1.5).kind == "generalised"


def test_entries_that_learned_nothing_are_not_generalised_from(database: Database) -> None:
    for amplitude in (0.02, 0.06):
        database.record(recording(amplitude))
    worse, _ = database.record(recording(0.04, error=1e-3))
    database.record(recording(0.04, applied=worse.served.weights, error=2e-3))
    found = database.query("squat", amplitude=0.05, frequency=0.25)
    assert found.provenance["entries"] == [1, 2]


def test_generalised_follows_the_database(database: Database) -> None:
    for amplitude in (0.02, 0.06):
        database.record(recording(amplitude))
    before = database.query("squat", amplitude=0.05, frequency=0.25)
    database.record(recording(0.04))
    after = database.query("squat", amplitude=0.05, frequency=0.25)
    assert after.provenance["entries"] == [1, 2, 3]
    assert np.abs(after.weights - before.weights).max() > 1e-9
    database.forget(3)
    again = database.query("squat", amplitude=0.05, frequency=0.25)
    np.testing.assert_allclose(again.weights, before.weights, atol=1e-12)


@pytest.mark.parametrize("what", ["basis", "axes", "formulation"])
def test_unlike_entries_are_not_generalised_together(database: Database, what: str) -> None:
    database.record(recording(0.02))
    different = {
        "basis": {"basis": PeriodicBasis(25, 60.0)},
        "axes": {"axes": ("com.x",)},
        "formulation": {"context": replace(CONTEXT, formulation="beef")},
    }[what]
    database.record(recording(0.04, **different))  # type: ignore[arg-type]
    with pytest.raises(EntryNotFound, match="different bases, axes or formulations"):
        database.query("squat", amplitude=0.03, frequency=0.25)


def test_the_robot_has_to_be_named_when_there_are_two(database: Database) -> None:
    database.record(recording(robot="one"))
    assert database.query("squat", amplitude=0.03, frequency=0.25).provenance["entries"] == [1]
    database.record(recording(robot="two"))
    with pytest.raises(EntryNotFound, match=r"name the robot.*one, two"):
        database.query("squat", amplitude=0.03, frequency=0.25)
    found = database.query("squat", robot="two", amplitude=0.03, frequency=0.25)
    assert found.provenance["entries"] == [2]
    with pytest.raises(EntryNotFound):
        database.query("squat", robot="three", kind="learned", amplitude=0.03, frequency=0.25)


def test_one_robots_entries_are_not_generalised_for_another(database: Database) -> None:
    for amplitude in (0.02, 0.06):
        database.record(recording(amplitude, robot="one"))
    database.record(recording(0.02, robot="two"))
    with pytest.raises(EntryNotFound):
        database.query("squat", robot="two", amplitude=0.04, frequency=0.25)


# files


def test_a_mistyped_folder_is_refused_rather_than_made(tmp_path: Path) -> None:
    with pytest.raises(DatabaseError, match=rf"there is no folder {tmp_path / 'a'}.*make that"):
        Database(tmp_path / "a" / "d.sqlite")
    assert list(tmp_path.iterdir()) == []


def test_only_the_usual_folder_is_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "a" / "b"
    monkeypatch.setattr("platformdirs.user_data_dir", lambda _: str(folder))
    with Database(default_path()) as database:
        assert database.path == folder / "feedforward.sqlite"


def test_a_usual_folder_that_cannot_be_made_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setattr("platformdirs.user_data_dir", lambda _: str(tmp_path / "file" / "b"))
    with pytest.raises(DatabaseError, match="there is no folder"):
        Database(default_path())


def test_an_empty_file_is_a_new_database(path: Path) -> None:
    path.touch()
    with Database(path) as database:
        assert database.entries() == []


def _other_application(path: Path) -> None:
    with closing(sqlite3.connect(path)) as other:
        other.execute("CREATE TABLE photos (id INTEGER)")
        other.commit()


def _other_application_with_our_tables(path: Path) -> None:
    with closing(sqlite3.connect(path)) as other:
        other.executescript("CREATE TABLE entry (id INTEGER); CREATE TABLE iteration (id INTEGER);")


def _other_application_id(path: Path) -> None:
    with closing(sqlite3.connect(path)) as other:
        other.execute("PRAGMA application_id = 12345")
        other.commit()


def _newer_schema(path: Path) -> None:
    with Database(path) as database:
        database.record(recording())
    with closing(sqlite3.connect(path)) as other:
        other.execute(f"PRAGMA user_version = {SCHEMA_VERSION + 1}")
        other.commit()


def _truncated(path: Path) -> None:
    with Database(path) as database:
        database.record(recording())
    path.write_bytes(path.read_bytes()[:2000])


def _no_text_in_the_schema(path: Path) -> None:
    Database(path).close()
    path.write_bytes(path.read_bytes().replace(b"CREATE TABLE entry", b"CREATE T\xe4BLE entry"))


def _older_and_damaged(path: Path, parameters: str) -> None:
    with Database(path) as database:
        database.record(recording())
    with closing(sqlite3.connect(path)) as other:
        other.execute("UPDATE entry SET parameters = ?", (parameters,))
        other.execute("PRAGMA user_version = 2")
        other.commit()


NOT_OURS: dict[str, Callable[[Path], Any]] = {
    "random bytes": lambda path: path.write_bytes(np.random.default_rng(0).bytes(5000)),
    "text": lambda path: path.write_text("amplitude,frequency\n0.03,0.25\n"),
    "almost sqlite": lambda path: path.write_bytes(b"SQLite format 3\x00" + b"\xff" * 200),
    "another application": _other_application,
    "another application with our tables": _other_application_with_our_tables,
    "another application id": _other_application_id,
    "newer schema": _newer_schema,
    "truncated": _truncated,
    "no text in the schema": _no_text_in_the_schema,
    "older, with a number for parameters": partial(_older_and_damaged, parameters="5"),
    "older, with cut parameters": partial(_older_and_damaged, parameters='{"amplitude": '),
    "older, with endless parameters": partial(_older_and_damaged, parameters="[" * 5000),
}


@pytest.mark.parametrize("kind", NOT_OURS)
def test_a_file_that_is_not_ours_is_refused_and_left_as_it_was(path: Path, kind: str) -> None:
    NOT_OURS[kind](path)
    before = path.read_bytes()
    with pytest.raises(DatabaseError, match="is not a database of this project") as caught:
        Database(path)
    assert caught.value.path == path
    assert str(path) in str(caught.value)
    assert path.read_bytes() == before
    assert [item.name for item in path.parent.iterdir()] == [path.name]


def test_a_newer_schema_is_named(path: Path) -> None:
    _newer_schema(path)
    with pytest.raises(DatabaseError, match=r"schema version 4, this software knows 1 to 3"):
        Database(path)


def test_our_files_are_marked(path: Path, database: Database) -> None:
    with closing(sqlite3.connect(path)) as plain:
        assert plain.execute("PRAGMA application_id").fetchone() == (APPLICATION_ID,)
        assert plain.execute("PRAGMA user_version").fetchone() == (SCHEMA_VERSION,)
    assert path.read_bytes()[68:72] == b"TSDC"


def test_a_folder_in_place_of_the_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DatabaseError, match="cannot be opened"):
        Database(tmp_path)


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(DatabaseError, match=r"cannot be opened.*folder you may write to"):
        Database(tmp_path / "file" / "d.sqlite")


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs /proc")
def test_a_folder_that_cannot_be_made_is_refused() -> None:
    with pytest.raises(DatabaseError, match="cannot be opened"):
        Database("/proc/tsd_casadi/d.sqlite")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_an_unwritable_folder_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(DatabaseError, match="cannot be opened"):
        Database(tmp_path / "d.sqlite")


# several connections


def test_two_connections_see_each_others_records(path: Path) -> None:
    with Database(path) as one, Database(path) as other:
        first, _ = one.record(recording())
        assert_same(first, other.entries()[0])
        other.record(recording(applied=first.served.weights, error=0.5e-3))
        assert one.query("squat", amplitude=0.03, frequency=0.25).iteration == 2
        one.forget(1)
        assert other.entries() == []


def test_concurrent_recordings_are_all_kept(path: Path) -> None:
    Database(path).close()
    problems: list[BaseException] = []

    def work(robot: str) -> None:
        try:
            with Database(path) as database:
                for index in range(8):
                    database.record(recording(0.01 + index / 1000, robot=robot))
                    # one entry that both write to, each time with weights of its own
                    applied = np.full((1, BASIS.L), index + (robot == "two") / 2 + 1.0)
                    database.record(recording(robot="shared", applied=applied), told(update=False))
        except BaseException as error:
            problems.append(error)

    threads = [threading.Thread(target=work, args=(name,)) for name in ("one", "two")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert problems == []
    with Database(path) as database:
        assert len(database.entries("one")) == len(database.entries("two")) == 8
        (shared,) = database.entries("shared")
    assert len(shared.iterations) == 1 + 16


@pytest.mark.usefixtures("impatient")
def test_a_locked_database_is_reported_and_works_again_afterwards(path: Path) -> None:
    with Database(path) as database, closing(sqlite3.connect(path)) as other:
        database.record(recording())
        other.execute("BEGIN EXCLUSIVE")
        for attempt in (
            lambda: database.record(recording(0.05)),
            lambda: database.query("squat", amplitude=0.03, frequency=0.25),
            lambda: database.forget(1),
        ):
            with pytest.raises(DatabaseError, match=r"locked.*another process holds it"):
                attempt()
        other.rollback()
        database.record(recording(0.05))
        assert len(database.entries()) == 2


@pytest.mark.usefixtures("impatient")
def test_readers_are_served_while_another_process_writes(path: Path) -> None:
    with Database(path) as database, closing(sqlite3.connect(path)) as other:
        database.record(recording())
        other.execute("BEGIN IMMEDIATE")
        other.execute("DELETE FROM entry")
        assert database.query("squat", amplitude=0.03, frequency=0.25).kind == "learned"
        other.rollback()


# processes that die

DYING = """
import os, sys
sys.path.insert(0, os.path.dirname(sys.argv[2]))
import test_database as t
database = t.Database(sys.argv[1])
entry, _ = database.record(t.recording(error=1e-3))
database.record(t.recording(0.05))
file = database._file
with file.transaction():
    database._rows.delete(entry.identifier)
    file.execute("UPDATE entry SET robot = 'nobody'")
    # as if the pages had been written out before the end of the transaction
    file.connection.execute("PRAGMA cache_spill = 1")
    file.execute("UPDATE iteration SET weights = weights || ?", (" " * 5_000_000,))
    os._exit(9)
"""


def test_a_process_that_dies_inside_a_transaction_loses_nothing(path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", DYING, str(path), __file__], timeout=60)
    assert done.returncode == 9
    assert path.with_name(f"{path.name}-journal").stat().st_size > 0  # it was half written
    with Database(path) as database:
        entries = database.entries()
        assert [dict(entry.key.parameters)["amplitude"] for entry in entries] == [0.03, 0.05]
        assert {entry.key.robot for entry in entries} == {"hermes_lower"}
        assert [len(entry.iterations) for entry in entries] == [2, 2]
        assert database.query("squat", amplitude=0.03, frequency=0.25).iteration == 1
        database.record(recording(0.07))


RECORDING = """
import os, sys
sys.path.insert(0, os.path.dirname(sys.argv[2]))
import test_database as t
database = t.Database(sys.argv[1])
for number in range(1, 100_000):
    database.record(t.recording(number / 1e5))
    print(number, flush=True)
"""


def test_what_was_answered_is_kept_when_the_process_is_killed(path: Path) -> None:
    command = [sys.executable, "-c", RECORDING, str(path), __file__]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        lines = [process.stdout.readline() for _ in range(20)]
        process.send_signal(signal.SIGKILL)
        lines += process.stdout.readlines()
    answered = [int(line) for line in lines if line.endswith("\n")]
    assert answered == list(range(1, len(answered) + 1))
    assert len(answered) >= 20
    with Database(path) as database:
        entries = database.entries()
        # at most the one that was under way comes on top
        assert len(answered) <= len(entries) <= len(answered) + 1
        assert all(len(entry.iterations) == 2 for entry in entries)
        database.record(recording(0.07))


@pytest.mark.usefixtures("impatient")
def test_a_reader_that_blocks_one_record_does_not_block_the_next(path: Path) -> None:
    with Database(path) as database, closing(sqlite3.connect(path)) as reader:
        database.record(recording())
        reader.execute("BEGIN")
        reader.execute("SELECT * FROM entry").fetchall()
        with pytest.raises(DatabaseError, match="locked"):
            database.record(recording(0.05))
        reader.rollback()
        database.record(recording(0.05))
        assert len(database.entries()) == 2


@pytest.mark.usefixtures("impatient")
def test_a_database_that_is_locked_while_opening_is_said_to_be_locked(path: Path) -> None:
    Database(path).close()
    with closing(sqlite3.connect(path)) as other:
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(DatabaseError, match="locked") as caught:
            Database(path)
        assert "not a database of this project" not in str(caught.value)


def test_two_processes_may_make_the_same_new_database(path: Path) -> None:
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        # the other process is in the middle of making the tables
        other.execute("BEGIN IMMEDIATE")
        for statement in SCHEMA.split(";")[:-1]:
            other.execute(statement)
        other.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        other.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
        timer = threading.Timer(0.3, lambda: None)
        opened: list[Any] = []

        def open_it() -> None:
            try:
                Database(path).close()
                opened.append(None)
            except TsdError as error:
                opened.append(error)

        thread = threading.Thread(target=open_it)
        thread.start()
        timer.start()
        timer.join()
        other.execute("COMMIT")
        thread.join()
    assert opened == [None]


def test_an_entry_forgotten_while_it_is_read_is_not_half_read(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Database(path) as database, Database(path) as other:
        database.record(recording())
        execute = database._file.execute

        def forgotten_in_between(statement: str, values: tuple[Any, ...] = ()) -> Any:
            if "FROM iteration" in statement:
                other._file.connection.execute("PRAGMA busy_timeout = 50")
                with suppress(DatabaseError):  # locked out by the reader, as it should be
                    other.forget(1)
            return execute(statement, values)

        monkeypatch.setattr(database._file, "execute", forgotten_in_between)
        assert all(entry.iterations for entry in database.entries())


@pytest.mark.parametrize("what", ["error", "feedback", "applied"])
def test_a_recording_that_is_not_finite_is_refused(database: Database, what: str) -> None:
    nan = float("nan")
    changes = {
        "error": {"errors": {"rms_error_m": nan}},
        "feedback": {"laps": [Lap(PHASE, np.full((1, 100), nan))]},
        "applied": {"applied": np.full((1, BASIS.L), nan)},
    }[what]
    database.record(recording())
    with pytest.raises(TsdError):
        database.record(recording(**changes))  # type: ignore[arg-type]


def test_a_query_without_amplitude_is_refused_with_a_reason(trained: Database) -> None:
    with pytest.raises(TsdError, match="amplitude"):
        trained.query("squat", frequency=0.25)


def test_an_unknown_kind_is_refused(trained: Database) -> None:
    with pytest.raises(TsdError, match="learned or generalised"):
        trained.query("squat", kind="learnt", amplitude=0.04, frequency=0.25)


def test_after_a_restart_with_other_axes_the_new_entry_is_served(database: Database) -> None:
    database.record(recording(axes=("com.z",)))
    database.record(recording(axes=("body.z",)), told(restart=True))
    assert database.query("squat", amplitude=0.03, frequency=0.25).axes == ("body.z",)


# files of version 1


def make_version_1(path: Path) -> None:
    """A file as this software's version 0.1 left it: two squats and a motion of somebody's own."""
    context = {"formulation": "00ff", "model": "ab", "gains": {"P": [50.0]}, "version": "0.1.0"}
    with closing(sqlite3.connect(path, isolation_level=None)) as old:
        old.executescript(SCHEMA_1)
        for number, (task, parameters) in enumerate(
            [
                ("squat", {"amplitude": 0.02, "frequency": 0.25}),
                ("squat", {"amplitude": 0.06, "frequency": 0.25}),
                ("bow", {"depth": 1.0}),
            ],
            start=1,
        ):
            old.execute(
                "INSERT INTO entry VALUES (?, 'hermes_lower', ?, ?, ?, 2, 5.0, ?, 0.5, 'guarded', "
                "'2026-01-02T03:04:05+00:00')",
                (number, task, '["com.z"]', json.dumps(parameters), json.dumps(context)),
            )
            for iteration in (
                (number, 0, "[[0.0, 0.0]]", '{"rms_error_m": 0.01}', '{"P": [50.0]}'),
                (number, 1, f"[[-0.7, {number}]]", None, None),
            ):
                old.execute("INSERT INTO iteration VALUES (?, ?, ?, ?, ?)", iteration)
        old.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        old.execute("PRAGMA user_version = 1")


SCHEMA_1 = """
CREATE TABLE entry (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    robot TEXT NOT NULL,
    task TEXT NOT NULL,
    axes TEXT NOT NULL,
    parameters TEXT NOT NULL,
    basis_size INTEGER NOT NULL,
    basis_width REAL NOT NULL,
    context TEXT NOT NULL,
    learning_gain REAL NOT NULL,
    rule TEXT NOT NULL,
    updated TEXT NOT NULL,
    UNIQUE (robot, task, axes, parameters)
);
CREATE TABLE iteration (
    entry INTEGER NOT NULL REFERENCES entry (id) ON DELETE CASCADE,
    number INTEGER NOT NULL,
    weights TEXT NOT NULL,
    errors TEXT,
    gains TEXT,
    PRIMARY KEY (entry, number)
);
"""


def test_a_version_1_file_is_brought_up_to_date(path: Path) -> None:
    make_version_1(path)
    for _ in range(2):  # the second time there is nothing left to do
        with Database(path) as database:
            first, second, own = database.entries()
        assert dict(first.key.parameters) == {"amplitude": 0.02, "frequency": 0.25, "height": 0.0}
        assert dict(own.key.parameters) == {"depth": 1.0}
        assert (first.learning_gain, first.rule.name) == (0.5, "guarded")
        assert first.updated == "2026-01-02T03:04:05+00:00"
        assert [item.errors for item in second.iterations] == [{"rms_error_m": 0.01}, None]
        assert [item.feedback for item in second.iterations] == [None, None]
        np.testing.assert_array_equal(second.iterations[1].weights, [[-0.7, 2.0]])
    with closing(sqlite3.connect(path)) as plain:
        assert plain.execute("PRAGMA user_version").fetchone() == (SCHEMA_VERSION,)
        assert plain.execute("PRAGMA integrity_check").fetchone() == ("ok",)


def test_learning_goes_on_in_a_version_1_file(path: Path) -> None:
    make_version_1(path)
    with Database(path) as database:
        assert database.query("squat", amplitude=0.02, frequency=0.25).kind == "learned"
        assert database.query("squat", amplitude=0.04, frequency=0.25).kind == "generalised"
        context = database.entries()[0].context
        made = recording(
            0.02, basis=PeriodicBasis(2, 5.0), applied=np.array([[-0.7, 1.0]]), context=context
        )
        entry, _ = database.record(made)
        assert entry.identifier == 1
        assert [item.number for item in entry.iterations] == [0, 1, 2]


def test_a_version_1_file_that_cannot_be_brought_up_to_date_is_left_as_it_was(path: Path) -> None:
    make_version_1(path)
    with closing(sqlite3.connect(path)) as old:
        # what the first entry is going to be is there already
        parameters = '{"amplitude": 0.02, "frequency": 0.25, "height": 0.0}'
        old.execute("UPDATE entry SET parameters = ? WHERE id = 2", (parameters,))
        old.commit()
    before = path.read_bytes()
    with pytest.raises(DatabaseError, match="UNIQUE"):
        Database(path)
    assert path.read_bytes() == before


def test_signals_of_a_test_are_kept(path: Path) -> None:
    error, reference = np.cos(PHASE)[None, :] / 300, np.sin(PHASE)[None, :] / 30
    made = recording()
    laps = [replace(lap, error=error, reference=reference) for lap in made.laps]
    with Database(path) as database:
        entry, _ = database.record(replace(made, laps=laps))
    with Database(path) as database:
        (found,) = database.entries()
    assert_same(entry, found)
    tested, untested = found.iterations
    for name in FITTED:
        assert getattr(tested, name) is not None
        assert getattr(untested, name) is None
    for weights, values in (
        (tested.feedback, made.laps[0].feedback),
        (tested.error_weights, error),
        (tested.reference_weights, reference),
    ):
        assert weights is not None
        span = np.ptp(values)
        np.testing.assert_allclose(BASIS.evaluate(PHASE, weights), values, atol=1e-2 * span)


def test_an_entry_from_a_file_goes_on_like_one_in_memory(path: Path) -> None:
    kept = Entry(recording().key, BASIS, CONTEXT)
    # the third is worse, the second again, and on from there
    for number, error in enumerate((1.0, 0.3, 0.4, 0.3, 0.1)):
        noise = np.random.default_rng(number).normal(0, 1e-4, PHASE.size)
        position_error = (1e-3 * error * np.cos(PHASE) + noise)[None, :]
        lap = Lap(PHASE, 50 * position_error, position_error, 0.03 * np.sin(PHASE)[None, :])
        applied = kept.served.weights if kept.iterations else np.zeros((1, BASIS.L))
        made = recording(applied=applied, error=error, laps=[lap])
        kept.add(made, told("stable"))
        with Database(path) as database:  # opened anew each time
            stored, _ = database.record(made, told("stable"))
        kept.key, kept.identifier, kept.updated = stored.key, stored.identifier, stored.updated
        assert_same(kept, stored)
    with Database(path) as database:
        (found,) = database.entries()
    assert_same(kept, found)
    assert found.contractions == kept.contractions
    assert [item.learned_from for item in found.iterations] == [None, 0, 1, 1, 3]


def test_a_version_2_file_is_brought_up_to_date(path: Path) -> None:
    with Database(path) as database:
        database.record(recording())
    with closing(sqlite3.connect(path)) as old:
        old.execute("ALTER TABLE iteration DROP COLUMN learned_from")
        old.execute("PRAGMA user_version = 2")
        old.commit()
    with Database(path) as database:
        (entry,) = database.entries()
        assert [item.learned_from for item in entry.iterations] == [None, None]
        entry, _ = database.record(recording(applied=entry.served.weights, error=1e-4))
        assert [item.learned_from for item in entry.iterations] == [None, None, 1]


# where to learn next


def learn_at(database: Database, places: list[tuple[float, float]]) -> None:
    for amplitude, frequency in places:
        database.record(recording(amplitude, frequency))


REGION = {"amplitude": (0.02, 0.08), "frequency": (0.2, 0.6)}


def test_first_the_middle_then_the_corners(database: Database) -> None:
    visited = []
    for _ in range(5):
        place = database.suggest("squat", robot="hermes_lower", region=REGION)
        assert place.parameters["height"] == 0.0
        visited.append((place.parameters["amplitude"], place.parameters["frequency"]))
        learn_at(database, [visited[-1]])
    assert visited[0] == (0.05, 0.4)
    assert set(visited[1:]) == {(a, f) for a in (0.02, 0.08) for f in (0.2, 0.6)}


def test_the_deviation_is_unknown_until_a_regression_is_possible(database: Database) -> None:
    assert database.suggest("squat", region=REGION).standard_deviation is None
    learn_at(database, [(0.02, 0.2), (0.08, 0.2)])
    # of the frequency they say nothing
    assert database.suggest("squat", region=REGION).standard_deviation is None
    learn_at(database, [(0.05, 0.6)])
    deviation = database.suggest("squat", region=REGION).standard_deviation
    assert deviation is not None
    assert deviation > 0


def test_the_hole_is_suggested(database: Database) -> None:
    grid = [(a, f) for a in (0.02, 0.035, 0.05, 0.065, 0.08) for f in (0.2, 0.3, 0.4, 0.5, 0.6)]
    hole = {(a, f) for a in (0.05, 0.065) for f in (0.3, 0.4)}
    learn_at(database, [place for place in grid if place not in hole])
    place = database.suggest("squat", region=REGION)
    assert place.parameters["amplitude"] == pytest.approx(0.0575, abs=0.0076)
    assert place.parameters["frequency"] == pytest.approx(0.35, abs=0.051)


def test_the_suggested_place_is_the_most_uncertain(database: Database) -> None:
    rng = np.random.default_rng(1)
    learn_at(database, [(a, f) for a, f in rng.uniform((0.02, 0.2), (0.08, 0.6), (9, 2)).round(4)])
    place = database.suggest("squat", region=REGION)
    best = database.query("squat", extrapolate=True, **place.parameters)
    lap = np.linspace(0, 2 * np.pi, 200, endpoint=False)

    def deviation(feedforward: Any) -> float:
        return float(np.sqrt(np.mean(feedforward.std(lap) ** 2)))

    assert deviation(best) == pytest.approx(place.standard_deviation, rel=1e-6)
    for amplitude, frequency in rng.uniform((0.02, 0.2), (0.08, 0.6), (30, 2)):
        other = database.query("squat", extrapolate=True, amplitude=amplitude, frequency=frequency)
        # a place between those of the grid may be a little worse
        assert deviation(other) < 1.05 * deviation(best)


def test_one_parameter_may_be_fixed(database: Database) -> None:
    learn_at(database, [(a, f) for a in (0.02, 0.08) for f in (0.2, 0.6)])
    place = database.suggest("squat", region={"amplitude": (0.02, 0.08)}, frequency=0.2)
    assert place.parameters["frequency"] == 0.2
    assert place.parameters["amplitude"] == pytest.approx(0.05, abs=1e-6)


def test_entries_at_another_height_say_nothing_of_this_one(database: Database) -> None:
    learn_at(database, [(a, f) for a in (0.02, 0.05, 0.08) for f in (0.2, 0.4, 0.6)])
    place = database.suggest("squat", region=REGION, height=0.02)
    assert place.parameters == {"amplitude": 0.05, "frequency": 0.4, "height": 0.02}
    assert place.standard_deviation is None


def test_a_place_where_nothing_was_learned_is_not_suggested_again(database: Database) -> None:
    worse, _ = database.record(recording(0.05, 0.4, error=1e-3))
    database.record(recording(0.05, 0.4, applied=worse.served.weights, error=2e-3))
    place = database.suggest("squat", region=REGION)
    assert (place.parameters["amplitude"], place.parameters["frequency"]) != (0.05, 0.4)


def test_entries_of_one_frequency_say_nothing_of_others(database: Database) -> None:
    """Not even if the lowest corner of the region has that frequency."""
    learn_at(database, [(a, 0.2) for a in (0.02, 0.035, 0.05, 0.065, 0.08)])
    visited = set()
    for _ in range(4):
        place = database.suggest("squat", region=REGION)
        visited.add(place.parameters["frequency"])
        learn_at(database, [(place.parameters["amplitude"], place.parameters["frequency"])])
    assert max(visited) == 0.6


@pytest.mark.parametrize("high", [0.08, 0.0777])
def test_places_are_known_again_however_many_digits_they_have(
    database: Database, high: float
) -> None:
    region, fixed = {"amplitude": (0.02, high)}, {"frequency": 1 / 3}
    visited = []
    for _ in range(6):
        place = database.suggest("squat", region=region, **fixed)
        visited.append(place.parameters["amplitude"])
        learn_at(database, [(visited[-1], place.parameters["frequency"])])
    assert len(set(visited)) == 6


def test_a_region_without_a_free_place_is_refused(
    database: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tsd_casadi.generalization.suggestion.FINEST_GRID", 3)
    learn_at(database, [(a, 0.25) for a in (0.02, 0.05, 0.08)])
    with pytest.raises(EntryNotFound, match="every place"):
        database.suggest("squat", region={"amplitude": (0.02, 0.08)}, frequency=0.25)


@pytest.mark.parametrize(
    ("region", "fixed", "named"),
    [
        ({}, SQUAT, "the region"),
        ({"amplitude": (0.08, 0.02)}, {"frequency": 0.25}, "region of amplitude"),
        ({"amplitude": (0.02, 0.02)}, {"frequency": 0.25}, "region of amplitude"),
        ({"amplitude": (0.02, float("nan"))}, {"frequency": 0.25}, "region of amplitude"),
        ({"amplitude": (-0.02, 0.08)}, {"frequency": 0.25}, "amplitude is -0.02"),
        ({"amplitude": (0.02, 0.08)}, SQUAT, "region of amplitude"),
        ({"amplitude": (0.02, 0.08)}, {}, "without frequency"),
        ({"colour": (0.02, 0.08)}, SQUAT, "'colour'"),
    ],
)
def test_regions_that_make_no_sense_are_refused(
    database: Database, region: Any, fixed: dict[str, float], named: str
) -> None:
    with pytest.raises(InvalidValue, match=named):
        database.suggest("squat", region=region, **fixed)


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE entry SET context = '{}'",
        "UPDATE entry SET axes = 'com.z'",
        "UPDATE entry SET axes = '[]'",
        "UPDATE entry SET axes = '[[1]]'",
        "UPDATE entry SET parameters = '5'",
        "UPDATE entry SET parameters = '[\"com.z\"]'",
        """UPDATE entry SET parameters = '{"amplitude": 1e999}'""",
        "UPDATE entry SET basis_size = 1e300",
        "UPDATE entry SET basis_size = 24",
        "UPDATE entry SET basis_width = 'wide'",
        "UPDATE entry SET learning_gain = x'00ff'",
        "UPDATE entry SET rule = 'unruly'",
        """UPDATE entry SET context = '{"gains": 1}'""",
        "UPDATE iteration SET weights = '[[1.0, '",
        "UPDATE iteration SET weights = '[[1.0]]'",
        "UPDATE iteration SET weights = replace(weights, '[[', '[[NaN, ')",
        """UPDATE iteration SET weights = '{"amplitude": 1}'""",
        "UPDATE iteration SET errors = '{}'",
        "UPDATE iteration SET errors = 'NaN'",
        """UPDATE iteration SET errors = '{"rms_error_m": null}'""",
        f"UPDATE iteration SET errors = '{'[' * 5000}'",
        "UPDATE iteration SET gains = '[1]'",
        "UPDATE iteration SET feedback = '[[null]]'",
        "UPDATE iteration SET number = 'first' WHERE number = 0",
    ],
)
def test_a_damaged_entry_is_named(path: Path, damage: str) -> None:
    with Database(path) as database:
        database.record(recording())
    with closing(sqlite3.connect(path)) as plain:
        plain.execute(damage)
        plain.commit()
    with Database(path) as database, pytest.raises(DatabaseError, match="damaged entry 1"):
        database.entries()
