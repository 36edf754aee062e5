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
from dataclasses import asdict, replace
from functools import partial
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tsd_casadi.database.database_file
from tsd_casadi.database.checksum import checksum
from tsd_casadi.database.database import Database, default_path
from tsd_casadi.database.schema import APPLICATION_ID, SCHEMA, SCHEMA_VERSION, TABLES
from tsd_casadi.database.transfer import Imported
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
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import NOWHERE, Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.motions.parameter import RESERVED, Parameter
from tsd_casadi.motions.squat import Squat

BASIS = PeriodicBasis()
CONTEXT = Context("00ff", "abcd")
MADE = Circumstances({"P": [50.0], "D": [14.0]}, {"hardware": "ideal"}, "0.1.0")
DECLARATION = Squat.declaration()
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
    motion: str = "squat",
    version: str = "1",
    axes: tuple[str, ...] = ("com.z",),
    context: Context = CONTEXT,
    error: float = 1e-3,
    **changes: Any,
) -> Recording:
    """A repetition without feedforward; what it needed grows with amplitude and frequency."""
    feedback = 0.7 + 30 * amplitude**2 + amplitude * np.sin(PHASE)
    feedback = feedback + 0.2 * frequency**2 * np.cos(PHASE)
    made = Recording(
        key=EntryKey.of(
            robot,
            motion,
            version,
            axes,
            {"amplitude": amplitude, "frequency": frequency},
            context,
        ),
        basis=BASIS,
        applied=np.zeros((len(axes), BASIS.L)),
        laps=[Lap(PHASE, np.tile(feedback, (len(axes), 1)))] * 2,
        errors={axis: AxisError(error) for axis in axes},
        circumstances=replace(MADE, gains={"P": [50.0] * len(axes), "D": [14.0] * len(axes)}),
        declaration=replace(DECLARATION, motion=motion, version=version),
    )
    return replace(made, **changes)


def squat_key(parameters: dict[str, float], motion: str = "squat") -> EntryKey:
    return EntryKey.of("hermes_lower", motion, "1", ("com.z",), parameters, CONTEXT)


def told(rule: str = "guarded", **changes: bool) -> Instruction:
    return Instruction(find_rule(rule), **changes)


def assert_same(one: Entry, other: Entry) -> None:
    assert (one.key, one.basis) == (other.key, other.basis)
    assert (one.circumstances, one.declaration) == (other.circumstances, other.declaration)
    assert (one.learning_gain, one.rule) == (other.learning_gain, other.rule)
    assert (one.identifier, one.updated) == (other.identifier, other.updated)
    assert one.sequence == other.sequence
    assert len(one.iterations) == len(other.iterations)
    for a, b in zip(one.iterations, other.iterations, strict=True):
        assert (a.number, a.errors) == (b.number, b.errors)
        assert (a.learned_from, a.epoch) == (b.learned_from, b.epoch)
        assert a.circumstances == b.circumstances
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


NAMES = st.text(min_size=1, max_size=20).filter(lambda text: "\x00" not in text)
PARAMETERS = NAMES.filter(lambda name: name not in RESERVED)


@settings(max_examples=settings.default.max_examples // 3)
@given(data=st.data())
def test_any_entry_comes_back_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    size = data.draw(st.integers(1, 6), "L")
    axes = tuple(data.draw(st.lists(NAMES, min_size=1, max_size=3, unique=True), "axes"))
    weights = st.lists(st.floats(-9.8, 9.8), min_size=size * len(axes), max_size=size * len(axes))
    applied = np.array(data.draw(weights, "applied")).reshape(len(axes), size)
    made = Recording(
        key=EntryKey.of(
            data.draw(NAMES, "robot"),
            data.draw(NAMES, "motion"),
            data.draw(NAMES, "version"),
            axes,
            data.draw(st.dictionaries(PARAMETERS, st.floats(-1e5, 1e5), max_size=3), "parameters"),
            Context(*(data.draw(NAMES) for _ in range(3))),
        ),
        basis=PeriodicBasis(size, data.draw(st.floats(0.1, 1e5), "width")),
        applied=applied,
        laps=[Lap(PHASE, np.ones((len(axes), 100)))] * 2,
        errors={
            axis: AxisError(data.draw(st.floats(0, 0.5)), ac_rms=data.draw(st.floats(0, 1e3)))
            for axis in axes
        },
        circumstances=Circumstances(
            {"P": [data.draw(st.floats(0, 1e5)) for _ in axes]},
            {data.draw(NAMES): data.draw(NAMES)},
            data.draw(NAMES),
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


def test_entries_are_told_apart_by_all_of_their_key(database: Database) -> None:
    first = recording()
    others = [
        recording(robot="mini"),
        recording(axes=("com.x",)),
        recording(0.04),
        recording(frequency=0.5),
        recording(motion="sway"),
        recording(version="2"),
        recording(context=replace(CONTEXT, body="beef")),
        recording(context=replace(CONTEXT, formulation="beef")),
        recording(context=replace(CONTEXT, correction="beef")),
    ]
    identifiers = {database.record(made)[0].identifier for made in (first, *others)}
    assert identifiers == set(range(1, 11))
    assert [entry.identifier for entry in database.entries("mini")] == [2]
    assert [entry.identifier for entry in database.entries(motion="sway")] == [6]
    assert database.entries("mini", "sway") == []


def in_order(axes: tuple[str, ...], amplitude: float = 0.03, **changes: Any) -> Recording:
    """A repetition that needed another feedback along each axis, named in some order."""
    share = {"com.z": 1.0, "com.x": 0.25, "torso.rz": -0.5}
    rows = np.array([share[axis] for axis in axes])[:, None]
    made = recording(amplitude, axes=axes, **changes)
    told = {"P": [50 * abs(share[axis]) for axis in axes], "D": [14.0] * len(axes)}
    return replace(
        made,
        laps=[replace(lap, feedback=rows * lap.feedback) for lap in made.laps],
        circumstances=replace(
            made.circumstances, gains=told, allowed=[10 + share[axis] for axis in axes]
        ),
    )


@pytest.mark.parametrize("axes", list(permutations(("com.z", "com.x", "torso.rz"))))
def test_the_order_in_which_axes_are_named_is_none_of_an_entry(
    database: Database, axes: tuple[str, ...]
) -> None:
    usual = ("com.z", "com.x", "torso.rz")
    first, _ = database.record(in_order(usual))
    learned = first.served.weights
    order = [usual.index(axis) for axis in axes]
    again, _ = database.record(
        in_order(axes, applied=learned[order], error=1e-4), told(update=False)
    )
    assert again.identifier == first.identifier
    assert (again.key, again.circumstances) == (first.key, first.circumstances)
    # the same weights are the same iteration, tested now
    assert [(each.number, each.errors is None) for each in again.iterations] == [
        (0, False),
        (1, False),
    ]
    np.testing.assert_array_equal(again.served.weights, learned)
    database.record(in_order(axes, 0.05))
    predicted = database.query("squat", axes=axes, amplitude=0.04, frequency=0.25)
    assert predicted.provenance["entries"] == [1, 2]
    assert predicted.axes == usual
    np.testing.assert_allclose(predicted.weights[1], 0.25 * predicted.weights[0], rtol=1e-6)


def test_entries_of_two_orders_from_elsewhere_do_not_keep_each_other_from_answering(
    database: Database, tmp_path: Path
) -> None:
    for amplitude in (0.02, 0.04):
        database.record(in_order(("com.z", "com.x"), amplitude))
    with Database(tmp_path / "other.sqlite") as other:
        other.record(in_order(("com.x", "com.z"), 0.02))
        other.export(tmp_path / "other.json")
    database.import_(tmp_path / "other.json")
    found = database.query("squat", axes=("com.x", "com.z"), amplitude=0.03, frequency=0.25)
    assert found.provenance["entries"] == [1, 2]


@pytest.mark.parametrize("kind", ["learned", "generalised"])
def test_who_asks_for_fewer_axes_than_were_learned_is_told_so(
    database: Database, kind: str
) -> None:
    database.record(recording(axes=("com.z", "com.x")))
    with pytest.raises(EntryNotFound) as caught:
        database.query("squat", kind=kind, axes=("com.z",), **SQUAT)
    asked, _, there = str(caught.value).partition("there is ")
    assert "along com.z" in asked and "com.x" not in asked
    assert there.startswith("squat amplitude=0.03 frequency=0.25 height=0 along com.z, com.x.")


def test_what_was_served_within_its_bound_is_the_iteration_that_is_tested(path: Path) -> None:
    at = {"amplitude": 0.03, "frequency": 0.25}
    small = replace(MADE, allowed=[0.5])  # less than is needed
    with Database(path) as database:
        database.record(recording(circumstances=small))
        served = database.query("squat", **at)
        tested, _ = database.record(
            recording(applied=served.weights, circumstances=small), told(update=False)
        )
    with Database(path) as database:
        assert database.verify() == []
        (kept,) = database.entries()
    for entry in (tested, kept):
        assert [(each.number, each.learned_from) for each in entry.iterations] == [
            (0, None),
            (1, 0),
        ]
        np.testing.assert_array_equal(entry.iterations[1].weights, served.weights)
        assert entry.iterations[1].errors is not None


def test_restart_forgets_only_that_entry(database: Database) -> None:
    entry, _ = database.record(recording())
    database.record(recording(applied=entry.served.weights, error=2e-3))
    other, _ = database.record(recording(0.05))
    again, notes = database.record(recording(error=5e-3), told(restart=True))
    assert notes == []
    assert again.identifier not in (entry.identifier, other.identifier)
    assert (again.learning_gain, [i.number for i in again.iterations]) == (1.0, [0, 1])
    assert [e.identifier for e in database.entries()] == [other.identifier, again.identifier]


def test_restart_accepts_another_basis(database: Database) -> None:
    database.record(recording())
    other = PeriodicBasis.of_size(10)
    made = recording(
        basis=other,
        applied=np.zeros((1, 10)),
    )
    with pytest.raises(IncompatibleEntry):
        database.record(made)
    database.record(made, told(restart=True))
    (entry,) = database.entries()
    assert entry.basis == other


def test_a_restart_that_fails_forgets_nothing(database: Database) -> None:
    before, _ = database.record(recording())
    with pytest.raises(InvalidValue, match="without error and reference"):
        database.record(recording(), told("stable", restart=True))
    (after,) = database.entries()
    assert_same(before, after)


def test_a_refused_recording_leaves_the_entry_alone(database: Database) -> None:
    before, _ = database.record(recording())
    with pytest.raises(IncompatibleEntry):
        database.record(recording(basis=PeriodicBasis(25, 60.0)), told("plain"))
    (after,) = database.entries()
    assert_same(before, after)


def test_forget_removes_entry_and_iterations(path: Path, database: Database) -> None:
    database.record(recording())
    kept, _ = database.record(recording(0.05))
    gone = database.forget(1)
    assert gone is not None
    assert gone.key.parameters[0] == ("amplitude", 0.03)
    assert [entry.identifier for entry in database.entries()] == [kept.identifier]
    with Database(path) as again:
        assert [entry.identifier for entry in again.entries()] == [kept.identifier]
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
    return WeightRegression(DECLARATION, names, inputs, [e.served.weights for e in entries], BASIS)


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


def test_an_entry_that_the_others_contradict_is_named(database: Database) -> None:
    amplitudes = (0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08)
    for amplitude in amplitudes:
        database.record(recording(amplitude))
    before = database.query("squat", amplitude=0.055, frequency=0.25)
    wrong = recording(0.045)
    laps = [replace(lap, feedback=-lap.feedback) for lap in wrong.laps]
    entry, _ = database.record(replace(wrong, laps=laps))
    found = database.query("squat", amplitude=0.055, frequency=0.25)
    (named,) = found.provenance["disagreeing"]
    assert (named["entry"], named["parameters"]["amplitude"]) == (entry.identifier, 0.045)
    assert named["deviations"] > 4
    assert entry.identifier not in found.provenance["entries"]
    np.testing.assert_allclose(found.weights, before.weights, atol=2e-3)
    assert [band.kind for band in found.bands] == ["pointwise", "simultaneous"]
    assert before.provenance["disagreeing"] == []


def test_what_is_generalised_says_of_which_robots_it_is(database: Database) -> None:
    settings = [{"model_error": 0.1, "seed": 3}, {"model_error": 0.2, "seed": 4}, {}]
    for amplitude, setting in zip((0.02, 0.04, 0.06), settings, strict=True):
        database.record(recording(amplitude, circumstances=replace(MADE, setting=setting)))
    found = database.query("squat", amplitude=0.05, frequency=0.25)
    assert found.provenance["entries"] == [1, 2, 3]
    assert found.provenance["hardware"] == [{"model_error": 0.1}, {"model_error": 0.2}, {}]


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
    key = squat_key(squat)
    (entry,) = database.entries()
    assert entry.key == key
    database.record(recording(key=key, applied=entry.served.weights, error=0.5e-3))
    assert len(database.entries()) == 1
    for height in ({}, {"height": 0.0}, {"height": -0.0}):
        found = database.query("squat", amplitude=0.03, frequency=0.25, **height)
        assert (found.kind, found.iteration) == ("learned", 2)


def test_squats_below_home_are_other_entries_to_generalise_over(database: Database) -> None:
    for height in (-0.02, 0.0, 0.02):
        key = squat_key({**SQUAT, "height": height})
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
        ({"amplitude": -0.01}, "amplitude is -0.01"),
        ({"frequency": -0.25}, "frequency is -0.25"),
        ({"frequency": float("nan")}, "frequency is nan"),
        ({"height": float("inf")}, "height is inf"),
        ({"colour": 1.0}, "'colour'"),
    ],
)
def test_parameters_that_make_no_sense_are_refused(
    database: Database, changes: dict[str, float], named: str
) -> None:
    known, _ = database.record(recording(0.07))
    parameters = {**SQUAT, **changes}
    key = replace(recording().key, parameters=tuple(parameters.items()))
    with pytest.raises(InvalidValue, match=named):
        database.record(recording(key=key))
    with pytest.raises(InvalidValue, match=named):
        database.query("squat", **parameters)
    assert [entry.identifier for entry in database.entries()] == [known.identifier]


def test_a_recording_without_amplitude_is_refused(database: Database) -> None:
    key = replace(recording().key, parameters=(("frequency", 0.25),))
    with pytest.raises(InvalidValue, match="without amplitude"):
        database.record(recording(key=key))


def test_motions_of_which_nothing_is_said_have_parameters_as_they_come(database: Database) -> None:
    for depth in (1.0, 2.0):
        key = squat_key({"depth": depth}, motion="bow")
        database.record(recording(key=key, declaration=None))
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
    with pytest.raises(EntryNotFound, match=r"different bases|needs at least 2"):
        database.query("squat", amplitude=0.03, frequency=0.25)
    database.record(recording(0.06, **different))  # type: ignore[arg-type]
    database.record(recording(0.08, **different))  # type: ignore[arg-type]
    if what == "basis":
        return
    found = database.query("squat", amplitude=0.05, frequency=0.25)
    assert found.provenance["entries"] == [2, 3, 4]


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
    make_version_1(path)
    with closing(sqlite3.connect(path)) as other:
        other.execute("UPDATE entry SET parameters = ? WHERE id = 1", (parameters,))
        other.commit()


def _without_a_column(path: Path) -> None:
    Database(path).close()
    with closing(sqlite3.connect(path)) as other:
        other.execute("DROP TRIGGER event_added")
        other.execute("DROP VIEW entry_state_of_rows")
        other.execute("ALTER TABLE event DROP COLUMN correction")
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
    "a column is missing": _without_a_column,
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
    with pytest.raises(DatabaseError, match=r"schema version 5, this software knows 1 to 4"):
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
        for attempt in (lambda: database.record(recording(0.05)), lambda: database.forget(1)):
            with pytest.raises(DatabaseError, match=r"locked.*another process holds it"):
                attempt()
        assert database.query("squat", amplitude=0.03, frequency=0.25).kind == "learned"
        other.rollback()
        database.record(recording(0.05))
        assert len(database.entries()) == 2


@pytest.mark.usefixtures("impatient")
def test_readers_are_served_while_another_process_writes(path: Path) -> None:
    with Database(path) as database, closing(sqlite3.connect(path)) as other:
        database.record(recording())
        other.execute("BEGIN IMMEDIATE")
        other.execute(
            "INSERT INTO entry SELECT 99, robot, motion, version, axes, parameters, "
            "basis_kind, basis, checksum FROM entry"
        )
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
    database._new_rows.forget(entry.identifier, "")
    # as if the pages had been written out before the end of the transaction
    file.connection.execute("PRAGMA cache_spill = 1")
    file.connection.execute("DROP TRIGGER iteration_UPDATE")
    file.execute("UPDATE iteration SET weights = weights || ?", (" " * 5_000_000,))
    os._exit(9)
"""


def test_a_process_that_dies_inside_a_transaction_loses_nothing(path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", DYING, str(path), __file__], timeout=60)
    assert done.returncode == 9
    assert path.with_name(f"{path.name}-wal").stat().st_size > 5_000_000  # it was half written
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
def test_a_reader_keeps_nobody_from_recording(path: Path) -> None:
    with Database(path) as database, closing(sqlite3.connect(path)) as reader:
        database.record(recording())
        reader.execute("BEGIN")
        before = reader.execute("SELECT * FROM entry").fetchall()
        database.record(recording(0.05))
        assert reader.execute("SELECT * FROM entry").fetchall() == before
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
        "error": {"errors": {"com.z": AxisError(nan)}},
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
        assert [item.errors for item in second.iterations] == [{"com.z": AxisError(0.01)}, None]
        assert [item.gains for item in second.iterations] == [{"P": [50.0]}, None]
        assert {entry.key.context for entry in (first, second, own)} == {NOWHERE}
        assert (first.key.version, own.key.version) == ("1", "1")
        assert first.declaration is not None
        assert first.declaration.unit_of("amplitude") == "m"
        assert own.declaration is None
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
        made = recording(0.02, basis=PeriodicBasis(2, 5.0), applied=np.array([[-0.7, 1.0]]))
        entry, _ = database.record(made)
        assert entry.identifier == 1
        assert [item.number for item in entry.iterations] == [0, 1, 2]


def test_signals_of_a_test_are_kept(path: Path) -> None:
    made = recording()
    # what P = 50 makes of the error, with 1 mm to and fro beside it
    error = made.laps[0].feedback / 50 + 1e-3 * np.cos(PHASE)
    reference = np.sin(PHASE)[None, :] / 30
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
    kept = Entry(squat_key({**SQUAT, "height": 0.0}), BASIS, MADE)
    # the third is worse by more than learning explains: another epoch goes on from there
    for number, error in enumerate((1.0, 0.3, 0.4, 0.3, 0.1)):
        noise = np.random.default_rng(number).normal(0, 1e-4, PHASE.size)
        position_error = (1e-3 * error * np.cos(PHASE) + noise)[None, :]
        lap = Lap(PHASE, 50 * position_error, position_error, 0.03 * np.sin(PHASE)[None, :])
        applied = kept.served.weights if kept.iterations else np.zeros((1, BASIS.L))
        made = recording(key=kept.key, applied=applied, error=error / 10, laps=[lap])
        kept.add(made, told("stable"))
        with Database(path) as database:  # opened anew each time
            stored, _ = database.record(made, told("stable"))
        kept.key, kept.identifier, kept.updated = stored.key, stored.identifier, stored.updated
        kept.sequence = stored.sequence
        assert_same(kept, stored)
    with Database(path) as database:
        (found,) = database.entries()
    assert_same(kept, found)
    assert found.contractions == kept.contractions
    assert [item.learned_from for item in found.iterations][:3] == [None, 0, 1]
    assert {item.epoch for item in found.iterations} == {0, 1}


# where to learn next


def learn_at(database: Database, places: list[tuple[float, float]]) -> None:
    for amplitude, frequency in places:
        database.record(recording(amplitude, frequency))


REGION = {"amplitude": (0.02, 0.08), "frequency": (0.2, 0.6)}


def test_first_the_middle_then_the_corners(database: Database) -> None:
    visited = []
    for _ in range(5):
        place = database.suggest("squat", robot="hermes_lower", region=REGION, height=0.0)
        assert place.parameters["height"] == 0.0
        visited.append((place.parameters["amplitude"], place.parameters["frequency"]))
        learn_at(database, [visited[-1]])
    assert visited[0] == (0.05, 0.4)
    assert set(visited[1:]) == {(a, f) for a in (0.02, 0.08) for f in (0.2, 0.6)}


def test_the_deviation_is_unknown_until_a_regression_is_possible(database: Database) -> None:
    assert database.suggest("squat", region=REGION, height=0.0).standard_deviation is None
    learn_at(database, [(0.02, 0.2), (0.08, 0.2)])
    # of the frequency they say nothing
    assert database.suggest("squat", region=REGION).standard_deviation is None
    learn_at(database, [(0.05, 0.6)])
    deviation = database.suggest("squat", region=REGION).standard_deviation
    assert deviation is not None
    assert deviation > 0


def test_the_hole_is_suggested(database: Database) -> None:
    # even by ratios
    amplitudes, frequencies = np.geomspace(0.02, 0.08, 5), np.geomspace(0.2, 0.6, 5)
    grid = [(a, f) for a in amplitudes.round(4) for f in frequencies.round(3)]
    hole = {(a, f) for a in amplitudes[1:4].round(4) for f in frequencies[1:4].round(3)}
    for amplitude, frequency in grid:
        if (amplitude, frequency) not in hole:
            made = recording(amplitude, frequency)
            # of what is a polynomial nothing is uncertain in a hole; steps of friction are
            steps = 0.5 * np.tanh(np.cos(PHASE) * 2 * np.pi * amplitude * frequency / 0.05)
            laps = [Lap(PHASE, lap.feedback + steps) for lap in made.laps]
            database.record(replace(made, laps=laps))
    place = database.suggest("squat", region=REGION)
    assert 0.024 < place.parameters["amplitude"] < 0.067
    assert 0.23 < place.parameters["frequency"] < 0.52


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
        place = database.suggest("squat", region=region, height=0.0, **fixed)
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
        ({"frequency": (0.2, 0.8)}, {}, "without amplitude"),
        ({"colour": (0.02, 0.08)}, SQUAT, "'colour'"),
    ],
)
def test_regions_that_make_no_sense_are_refused(
    database: Database, region: Any, fixed: dict[str, float], named: str
) -> None:
    database.record(recording(0.07))
    with pytest.raises(InvalidValue, match=named):
        database.suggest("squat", region=region, **fixed)


# damaged rows


def change(path: Path, *statements: str, checksums: bool = False) -> None:
    """Change rows behind our back, and on request their checksums too."""
    with closing(sqlite3.connect(path)) as plain:
        plain.row_factory = sqlite3.Row
        for table in TABLES:
            plain.execute(f"DROP TRIGGER {table}_UPDATE")
        for statement in statements:
            plain.execute(statement)
        for table in TABLES if checksums else ():
            for row in plain.execute(f"SELECT rowid AS place, * FROM {table}").fetchall():
                names = [name for name in row.keys() if name not in ("place", "checksum")]  # noqa: SIM118
                columns = {name: row[name] for name in names}
                plain.execute(
                    f"UPDATE {table} SET checksum = ? WHERE rowid = ?",
                    (checksum(columns), row["place"]),
                )
        plain.commit()


DAMAGES = [
    "UPDATE entry SET axes = 'com.z' WHERE id = 1",
    "UPDATE entry SET axes = '[]' WHERE id = 1",
    "UPDATE entry SET axes = '[[1]]' WHERE id = 1",
    "UPDATE entry SET parameters = '5' WHERE id = 1",
    "UPDATE entry SET parameters = '[\"com.z\"]' WHERE id = 1",
    """UPDATE entry SET parameters = '{"amplitude": 1e999}' WHERE id = 1""",
    "UPDATE entry SET basis = '{}' WHERE id = 1",
    """UPDATE entry SET basis = '{"L": 24, "width": 62.5}' WHERE id = 1""",
    """UPDATE entry SET basis = '{"L": 25, "width": "wide"}' WHERE id = 1""",
    "UPDATE entry SET basis_kind = 'polynomial' WHERE id = 1",
    "UPDATE event SET circumstances = '{}' WHERE entry = 1",
    """UPDATE event SET circumstances = '{"gains": 1}' WHERE entry = 1""",
    "UPDATE event SET learning_gain = x'00ff' WHERE entry = 1",
    "UPDATE event SET rule = 'unruly' WHERE entry = 1",
    "UPDATE event SET kind = 'dreamt' WHERE entry = 1",
    "UPDATE event SET declaration = '[1]' WHERE entry = 1",
    "UPDATE iteration SET weights = '[[1.0, ' WHERE entry = 1",
    "UPDATE iteration SET weights = '[[1.0]]' WHERE entry = 1",
    "UPDATE iteration SET weights = replace(weights, '[[', '[[NaN, ') WHERE entry = 1",
    """UPDATE iteration SET weights = '{"amplitude": 1}' WHERE entry = 1""",
    "UPDATE iteration SET errors = '{}' WHERE entry = 1",
    "UPDATE iteration SET errors = 'NaN' WHERE entry = 1",
    """UPDATE iteration SET errors = '{"com.z": {"rms": null}}' WHERE entry = 1""",
    """UPDATE iteration SET errors = '{"com.z": {"rms": -1.0}}' WHERE entry = 1""",
    """UPDATE iteration SET errors = '{"com.x": {"rms": 1.0}}' WHERE entry = 1""",
    f"UPDATE iteration SET errors = '{'[' * 5000}' WHERE entry = 1",
    "UPDATE iteration SET circumstances = '[1]' WHERE entry = 1",
    "UPDATE iteration SET feedback = '[[null]]' WHERE entry = 1",
    "UPDATE iteration SET number = 'first' WHERE entry = 1 AND number = 0",
]


@pytest.mark.parametrize("checksums", [False, True], ids=["as it is", "with its checksum"])
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_entry_is_named_and_the_others_stay_readable(
    path: Path, damage: str, checksums: bool
) -> None:
    with Database(path) as database:
        for amplitude in (0.03, 0.04, 0.06):
            database.record(recording(amplitude))
    change(path, damage, checksums=checksums)
    with Database(path) as database:
        assert [entry.identifier for entry in database.entries()] == [2, 3]
        assert [each.identifier for each in database.damaged()] == [1]
        with pytest.raises(DatabaseError, match="damaged entry 1"):
            database.query("squat", **SQUAT)
        with pytest.raises(DatabaseError, match="damaged entry 1"):
            database.record(recording())
        assert database.query("squat", amplitude=0.04, frequency=0.25).kind == "learned"
        assert database.query("squat", amplitude=0.05, frequency=0.25, kind="generalised")
        assert any(finding.startswith("entry 1") for finding in database.verify())
        assert database.forget(1) is None
        assert database.damaged() == []
        assert database.record(recording())[0].identifier == 4


@pytest.mark.parametrize("table", TABLES)
def test_any_changed_column_is_told(path: Path, table: str) -> None:
    with Database(path) as database:
        database.record(recording())
        assert database.verify() == []
        names = [row[1] for row in database._file.execute(f"PRAGMA table_info({table})")]
    whole = path.read_bytes()
    for name in names:
        path.write_bytes(whole)
        is_number = name in ("id", "entry", "event", "number", "epoch", "learned_from")
        is_number = is_number or name == "learning_gain"
        value = f"coalesce({name}, 0) + 10" if is_number else f"coalesce({name}, '') || ' '"
        change(path, "PRAGMA foreign_keys = OFF", f"UPDATE {table} SET {name} = {value}")
        with Database(path) as database:
            assert database.verify() != [], name


def test_an_old_row_that_counts_no_more_is_verified_too(path: Path) -> None:
    with Database(path) as database:
        entry, _ = database.record(recording())
        database.record(recording(applied=entry.served.weights, error=0.5e-3))
    change(path, "UPDATE iteration SET weights = '[]' WHERE number = 1 AND event = 1")
    with Database(path) as database:
        (entry,) = database.entries()
        assert entry.served.number == 2
        (finding,) = database.verify()
        assert "entry 1" in finding


def test_damaged_text_is_told_by_its_entry(path: Path) -> None:
    with Database(path) as database:
        for amplitude in (0.03, 0.04):
            database.record(recording(amplitude))
    change(path, "UPDATE event SET time = CAST(x'ff' AS TEXT) WHERE entry = 1")
    with Database(path) as database:
        assert [entry.identifier for entry in database.entries()] == [2]


def test_rows_are_only_ever_added(path: Path, database: Database) -> None:
    def rows() -> set[tuple[Any, ...]]:
        with closing(sqlite3.connect(path)) as plain:
            return {(t, *row) for t in TABLES for row in plain.execute(f"SELECT * FROM {t}")}

    before = rows()
    entry, _ = database.record(recording())
    for step in (
        lambda: database.record(recording(applied=entry.served.weights, error=2e-3)),
        lambda: database.record(recording(), told(restart=True)),
        lambda: database.forget(2),
    ):
        before = rows()
        step()
        assert before < rows()
    for statement in ("UPDATE event SET rule = 'plain'", "DELETE FROM iteration"):
        with pytest.raises(DatabaseError, match="only ever added"):
            database._file.execute(statement)


# contexts, versions and axes

OTHER = Context("beef", "abcd")


def test_the_newest_recordings_context_answers_and_others_are_counted(database: Database) -> None:
    database.record(recording(context=OTHER))
    database.record(recording(0.05, context=OTHER))
    newest, _ = database.record(recording())
    found = database.query("squat", **SQUAT)
    assert found.provenance["entries"] == [newest.identifier]
    assert found.provenance["context"] == {"body": "00ff", "formulation": "abcd", "correction": ""}
    assert found.provenance["others"] == 2
    assert "note" not in found.provenance
    found = database.query("squat", context=OTHER, **SQUAT)
    assert (found.provenance["entries"], found.provenance["others"]) == ([1], 1)
    with pytest.raises(EntryNotFound, match="2 of other contexts"):
        database.query("squat", kind="learned", amplitude=0.05, frequency=0.25)
    database.record(recording(0.05, context=OTHER))
    assert database.query("squat", **SQUAT).provenance["entries"] == [1]


def test_nothing_is_served_in_a_context_of_which_nothing_is_known(database: Database) -> None:
    for amplitude in (0.02, 0.04):
        database.record(recording(amplitude))
    for kind in ("learned", "generalised", None):
        with pytest.raises(EntryNotFound, match="2 of other contexts"):
            database.query("squat", kind=kind, context=OTHER, amplitude=0.03)


def test_gains_never_decide_what_is_served(database: Database) -> None:
    database.record(recording())
    soft = Circumstances({"P": [10.0], "D": [3.0]})
    entry, notes = database.record(recording(circumstances=soft, error=5e-3))
    assert (entry.identifier, len(database.entries())) == (1, 1)
    assert "gains differ" in notes[0]


def test_another_version_of_a_motion_is_another_motion(database: Database) -> None:
    database.record(recording())
    database.record(recording(0.05, version="2"))
    with pytest.raises(EntryNotFound):
        database.query("squat", kind="learned", **SQUAT)
    found = database.query("squat", kind="learned", version="1", **SQUAT)
    assert found.declaration is not None
    assert (found.provenance["entries"], found.declaration.version) == ([1], "1")


@pytest.mark.parametrize(
    ("axes", "entry"),
    [
        (("com.z",), 1),
        (("com.x", "com.z"), 2),
        (("com.z", "com.x"), 2),
        (("com.x", "com.y", "com.z"), 2),
        (("com.z", "torso.rz"), 1),
        (("torso.rz",), None),
        (None, 1),
    ],
)
def test_the_axes_that_are_asked_for_or_most_of_them(
    database: Database, axes: tuple[str, ...] | None, entry: int | None
) -> None:
    database.record(recording(axes=("com.z",)))
    database.record(recording(axes=("com.x", "com.z")))
    database.record(recording(axes=("com.z",), error=0.5e-3))
    if entry is None:
        with pytest.raises(EntryNotFound):
            database.query("squat", kind="learned", axes=axes, **SQUAT)
        return
    found = database.query("squat", axes=axes, **SQUAT)
    assert found.provenance["entries"] == [entry]
    assert tuple(found.provenance["axes"]) == found.axes
    if axes is not None:
        padded = found.over(axes)
        for axis, row in zip(axes, padded.weights, strict=True):
            assert row.any() == (axis in found.axes)


def test_generalised_comes_from_entries_of_one_set_of_axes(database: Database) -> None:
    for amplitude in (0.02, 0.04):
        database.record(recording(amplitude))
    database.record(recording(0.06, axes=("com.x", "com.z")))
    found = database.query("squat", axes=("com.x", "com.z"), amplitude=0.03)
    assert (found.axes, found.provenance["entries"]) == (("com.z",), [1, 2])
    database.record(recording(0.02, axes=("com.x", "com.z")))
    found = database.query("squat", axes=("com.x", "com.z"), amplitude=0.03)
    assert (found.axes, found.provenance["entries"]) == (("com.x", "com.z"), [3, 4])


def test_the_declaration_of_the_newest_recording_counts(database: Database) -> None:
    parameters = (
        Parameter("amplitude", "mm", low=0.0, high=100.0),
        Parameter("frequency", "Hz", default=0.25),
        Parameter("pause", "s", default=2.0),
    )
    told = Declaration("bow", "x1", parameters)
    key = EntryKey.of("hermes_lower", "bow", "x1", ("com.z",), {"amplitude": 30.0}, CONTEXT)
    entry, _ = database.record(recording(key=key, declaration=told))
    whole = {"amplitude": 30.0, "frequency": 0.25, "pause": 2.0}
    assert dict(entry.key.parameters) == whole
    # as a recording that says nothing, and as a query, see them
    assert database.record(recording(key=key, declaration=None))[0].identifier == 1
    assert database.query("bow", amplitude=30.0).parameters == whole
    with pytest.raises(InvalidValue, match="0 to 100 mm"):
        database.query("bow", amplitude=300.0)
    with pytest.raises(InvalidValue, match="did you mean 'pause'"):
        database.query("bow", amplitude=30.0, paus=1.0)


def test_a_declaration_of_another_motion_is_refused(database: Database) -> None:
    for changed in (replace(DECLARATION, motion="sway"), replace(DECLARATION, version="2")):
        with pytest.raises(InvalidValue, match="expected that of squat, version 1"):
            database.record(recording(declaration=changed))


# older files


def make_version_3(path: Path) -> None:
    """A file as the version before this one left it: two squats along com.z."""
    make_version_1(path)
    with closing(sqlite3.connect(path)) as old:
        for column in ("feedback", "error_weights", "reference_weights"):
            old.execute(f"ALTER TABLE iteration ADD COLUMN {column} TEXT")
        old.execute("ALTER TABLE iteration ADD COLUMN learned_from INTEGER")
        old.execute("UPDATE iteration SET learned_from = 0 WHERE number = 1")
        errors = {"rms_error_m": 0.01, "peak_error_m": 0.02, "mean_abs_feedback": 0.5}
        gains = {"P": [50.0], "D": [14.0], "W": [1.0]}
        old.execute(
            "UPDATE iteration SET feedback = '[[0.5, 0.25]]', errors = ?, gains = ? "
            "WHERE number = 0",
            (json.dumps(errors | {"true_rms_error_m": float("nan")}), json.dumps(gains)),
        )
        parameters = """json_set(parameters, '$.height', 0.0)"""
        old.execute(f"UPDATE entry SET parameters = {parameters} WHERE task = 'squat'")
        old.execute("PRAGMA user_version = 3")
        old.commit()


def test_a_version_3_file_keeps_everything(path: Path) -> None:
    make_version_3(path)
    with Database(path) as database:
        entry = database.entries()[0]
        assert database.verify() == []
    zero, one = entry.iterations
    assert zero.errors == {"com.z": AxisError(0.01, peak=0.02, mean_abs_feedback=0.5)}
    assert zero.gains == {"P": [50.0], "D": [14.0]}
    assert zero.feedback is not None
    np.testing.assert_array_equal(zero.feedback, [[0.5, 0.25]])
    assert (one.learned_from, one.epoch, one.uncertainty) == (0, 0, None)


@pytest.mark.parametrize("version", [1, 3])
def test_an_older_file_is_backed_up_first(path: Path, version: int) -> None:
    (make_version_1 if version == 1 else make_version_3)(path)
    before = path.read_bytes()
    backup = path.with_name(f"{path.name}.v{version}-backup")
    Database(path).close()
    assert backup.read_bytes() == before
    # an older file of the same name once more: the first backup stays
    path.write_bytes(before + b"\0" * 4096)
    with suppress(DatabaseError):
        Database(path).close()
    assert backup.read_bytes() == before


def test_without_room_for_a_backup_nothing_is_migrated(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_version_3(path)
    before = path.read_bytes()

    def full(_: object) -> None:
        raise InvalidValue("output file", "'backup' (No space left on device)", "a writable path")

    monkeypatch.setattr("tsd_casadi.database.migration.write_whole", full)
    with pytest.raises(DatabaseError, match=r"was not migrated.*No space left"):
        Database(path)
    assert path.read_bytes() == before
    assert [item.name for item in path.parent.iterdir()] == [path.name]


def test_migrated_entries_are_served_with_a_note_until_a_recording_matches(path: Path) -> None:
    make_version_3(path)
    with Database(path) as database:
        for context in (None, CONTEXT):
            found = database.query("squat", context=context, amplitude=0.02)
            assert (found.kind, found.provenance["entries"]) == ("learned", [1])
            assert "nobody knows" in found.provenance["note"]
            assert found.provenance["context"] == asdict(NOWHERE)
        between = database.query("squat", context=CONTEXT, amplitude=0.04)
        assert (between.kind, "note" in between.provenance) == ("generalised", True)
        basis = PeriodicBasis(2, 5.0)
        made = recording(0.02, basis=basis, applied=np.array([[-0.7, 1.0]]))
        entry, notes = database.record(made)
        assert (entry.identifier, entry.key.context) == (1, CONTEXT)
        assert any("entry 1" in note for note in notes)
    with Database(path) as database:
        first, second, _ = database.entries()
        assert (first.key.context, second.key.context) == (CONTEXT, NOWHERE)
        assert "note" not in database.query("squat", amplitude=0.02).provenance
        # the other one still serves, and another context makes an entry of its own
        assert "note" in database.query("squat", kind="learned", amplitude=0.06).provenance
        assert database.record(replace(made, key=replace(made.key, context=OTHER)))[
            0
        ].identifier not in (1, 2, 3)


def test_entries_of_fewer_axes_do_not_take_the_context_of_a_recording_of_more(path: Path) -> None:
    make_version_3(path)
    with Database(path) as database:
        basis = PeriodicBasis(2, 5.0)
        axes = ("com.x", "com.z")
        made = recording(0.02, axes=axes, basis=basis, applied=np.zeros((2, 2)))
        assert database.record(made)[0].identifier == 4
        assert database.entries()[0].key.context == NOWHERE


# export and import


def test_what_one_machine_learned_serves_on_another(path: Path, tmp_path: Path) -> None:
    file = tmp_path / "learned.jsonl"
    with Database(path) as database, Database(tmp_path / "other.sqlite") as other:
        for amplitude in (0.02, 0.04, 0.06):
            entry, _ = database.record(recording(amplitude))
        database.record(recording(0.06, applied=entry.served.weights, error=0.5e-3))
        database.record(recording(axes=("com.x", "torso.rz"), context=OTHER))
        own, _ = other.record(recording(0.04, error=9e-3))
        assert database.export(file) == 4
        assert other.import_(file) == Imported(added=3, skipped=1)
        assert other.import_(file) == Imported(added=0, skipped=4)
        assert_same(other.entries()[0], own)
        assert other.verify() == []
        by_key = {entry.key: entry for entry in other.entries()}
        for entry in database.entries():
            if entry.key != own.key:
                found = by_key[entry.key]
                entry.identifier, entry.sequence = found.identifier, found.sequence
                assert_same(found, entry)
        # what was recorded here is newer than anything imported
        assert other.query("squat", amplitude=0.06).provenance["context"] == asdict(CONTEXT)
        entry, _ = other.record(recording(0.02, applied=np.ones((1, BASIS.L))))
        assert entry.identifier == 2


def _with_another_number(lines: list[str]) -> None:
    lines[1] = lines[1].replace('"learning_gain":1.0', '"learning_gain":0.5')


SPOILT: dict[str, Callable[[list[str]], Any]] = {
    "empty": lambda lines: lines.clear(),
    "no header": lambda lines: lines.pop(0),
    "a line short": lambda lines: lines.pop(),
    "a cut line": lambda lines: lines.append(lines.pop()[:-30]),
    "another number": _with_another_number,
    "not ours": lambda lines: lines.insert(0, "amplitude,frequency"),
    "another version": lambda lines: lines.__setitem__(
        0, lines[0].replace("tsd.entries/1", "tsd.entries/9")
    ),
}


@pytest.mark.parametrize("how", SPOILT)
def test_a_spoilt_file_is_refused_and_nothing_imported(
    database: Database, tmp_path: Path, how: str
) -> None:
    file = tmp_path / "learned.jsonl"
    for amplitude in (0.02, 0.04):
        database.record(recording(amplitude))
    database.export(file)
    lines = file.read_text().splitlines()
    SPOILT[how](lines)
    file.write_text("".join(f"{line}\n" for line in lines))
    with Database(tmp_path / "other.sqlite") as other:
        with pytest.raises(InvalidValue, match=r"learned\.jsonl"):
            other.import_(file)
        assert other.entries() == []


def test_files_that_cannot_be_read_or_written_are_refused(
    database: Database, tmp_path: Path
) -> None:
    with pytest.raises(InvalidValue, match="No such file"):
        database.import_(tmp_path / "none.jsonl")
    with pytest.raises(InvalidValue, match="No such file"):
        database.export(tmp_path / "none" / "file.jsonl")


def test_what_later_versions_fill_is_kept_already(path: Path, tmp_path: Path) -> None:
    uncertainty = np.full((1, BASIS.L), 0.1)
    with Database(path) as database:
        entry, _ = database.record(recording())
        entry.iterations[1].epoch, entry.iterations[1].uncertainty = 3, uncertainty
        with database._file.transaction("IMMEDIATE"):
            database._new_rows.add(entry, "recorded")
        database.export(tmp_path / "learned.jsonl")
    with Database(path) as database, Database(tmp_path / "other.sqlite") as other:
        other.import_(tmp_path / "learned.jsonl")
        for opened in (database, other):
            (found,) = opened.entries()
            assert [item.epoch for item in found.iterations] == [0, 3]
            assert found.iterations[0].uncertainty is None
            np.testing.assert_array_equal(found.iterations[1].uncertainty, uncertainty)
            assert opened.query("squat", **SQUAT).provenance["epoch"] == 3
