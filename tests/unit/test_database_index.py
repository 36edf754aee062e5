"""What is read to answer a question, and what a full disk or another writer does to it."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.filled_database import ROBOT, fill, recording, squat
from tsd_casadi.database import derived
from tsd_casadi.database.database import Database
from tsd_casadi.database.entry_index import place
from tsd_casadi.database.iteration_rows import IterationOutline, IterationRow
from tsd_casadi.database.kept_entries import KEPT_ENTRIES, KeptEntries
from tsd_casadi.database.reading import Reading
from tsd_casadi.database.row import Row
from tsd_casadi.exceptions import DatabaseError, EntryNotFound, InvalidValue
from tsd_casadi.generalization import entry_regression
from tsd_casadi.generalization.weight_regression import WeightRegression
from tsd_casadi.learning.entry_key import EntryKey

FEW, MANY = 4, 400


@pytest.fixture(scope="module", params=[FEW, MANY])
def filled(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("filled") / f"{request.param}.sqlite"
    fill(path, request.param)
    return path


@pytest.fixture
def decoded(monkeypatch: pytest.MonkeyPatch) -> list[type[Row]]:
    """The kinds of the rows that are decoded from now on."""
    kinds: list[type[Row]] = []
    validate = Row.model_validate.__func__  # type: ignore[attr-defined]

    def counted(cls: type[Row], *arguments: Any, **options: Any) -> Row:
        kinds.append(cls)
        return validate(cls, *arguments, **options)

    monkeypatch.setattr(Row, "model_validate", classmethod(counted))
    return kinds


def ask(reading: Reading, number: int, **options: Any) -> Any:
    return reading.query("squat", robot=ROBOT, **squat(number), **options)


def test_a_filled_file_is_what_recordings_make(tmp_path: Path) -> None:
    fill(tmp_path / "filled", FEW)
    with Database(tmp_path / "filled") as filled, Database(tmp_path / "recorded") as recorded:
        assert filled.verify() == []
        for number in range(1, FEW + 1):
            recorded.record(recording(squat(number)))
        for one, other in zip(filled.entries(), recorded.entries(), strict=True):
            assert (one.key, one.sequence) == (other.key, other.sequence)
        np.testing.assert_array_equal(ask(filled, 1).weights, ask(recorded, 1).weights)


def test_an_exact_query_decodes_one_entry_and_the_weights_it_serves(
    filled: Path, decoded: list[type[Row]]
) -> None:
    with Database(filled) as database:
        answer = ask(database, 3)
        # the entry, its event (once more for the declaration), two iterations: what is served
        # and what it was learned from
        assert len(decoded) <= 7
        assert decoded.count(IterationOutline) == 2
        assert decoded.count(IterationRow) == 2
        decoded.clear()
        np.testing.assert_array_equal(ask(database, 3).weights, answer.weights)
        assert decoded == []


def test_a_recording_decodes_no_other_entry(filled: Path, decoded: list[type[Row]]) -> None:
    with Database(filled) as database:
        database.record(recording(squat(2)))
        # what was said of the motion and the entry; what it serves now, read back
        assert len(decoded) <= 5 + 8
        assert decoded.count(IterationRow) == 4


def test_what_was_just_recorded_is_answered_without_decoding(
    path: Path, decoded: list[type[Row]]
) -> None:
    kept = KeptEntries()
    with Database(path, kept) as database, Reading(path, kept) as reading:
        for number in (11, 2):  # a new entry and a known one
            entry, _ = database.record(recording(squat(number)))
            ask(reading, 1)  # what was said of the motion
            decoded.clear()
            answer = ask(reading, number)
            assert decoded == []
            with Database(path) as anew:
                np.testing.assert_array_equal(ask(anew, number).weights, answer.weights)
            np.testing.assert_array_equal(entry.served.weights, answer.weights)


def test_a_list_is_read_page_by_page_or_what_was_recorded_last(path: Path) -> None:
    with Database(path) as database:
        database.forget(4)
        database.record(recording(squat(2)))
        newest = database.outlines(most=3)
        assert [each.identifier for each in newest.entries] == [2, 9, 10]
        assert newest.more == 6
        found, after = [], 0
        while True:
            page = database.outlines(ROBOT, "squat", most=4, after=after)
            found += [each.identifier for each in page.entries]
            assert len(found) + page.more == 9
            if not page.more:
                break
            after = found[-1]
        assert found == [1, 2, 3, 5, 6, 7, 8, 9, 10]
        for nothing in (database.outlines("other"), database.outlines(motion="sway", after=0)):
            assert (nothing.entries, nothing.damaged, nothing.more) == ([], [], 0)


def test_a_list_decodes_no_weights(filled: Path, decoded: list[type[Row]]) -> None:
    with Database(filled) as database:
        page = database.outlines(ROBOT, "squat")
        outlines, damaged = page.entries, page.damaged
        assert IterationRow not in decoded
        assert damaged == []
        for one, other in zip(outlines, database.entries(), strict=True):
            assert (one.key, one.served.number) == (other.key, other.served.number)
            assert [each.errors for each in one.iterations] == [
                each.errors for each in other.iterations
            ]
            assert one.iterations[0].weights.shape == (3, 0)


def test_the_state_of_a_file_is_told_without_decoding(
    filled: Path, decoded: list[type[Row]]
) -> None:
    with Database(filled) as database:
        state = database.state()
        assert decoded == []
        assert state.entries == len(database.entries())
        assert state.damaged == 0
        assert state.schema_version == 4
        assert state.size >= filled.stat().st_size > 0
        assert state.last_write is not None


def test_the_state_of_a_new_file_is_nothing(tmp_path: Path) -> None:
    with Database(tmp_path / "d.sqlite") as database:
        state = database.state()
    assert (state.entries, state.damaged, state.last_write) == (0, 0, None)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A file of ten entries."""
    fill(tmp_path / "ten.sqlite", 10)
    return tmp_path / "ten.sqlite"


def test_an_index_statement_serves_every_lookup(path: Path) -> None:
    """No question scans a table, however many entries there are."""
    with Database(path) as database:
        plans: list[str] = []
        execute = database._file.execute

        def explained(statement: str, values: tuple[Any, ...] = ()) -> Any:
            if statement.startswith("SELECT"):
                plan = execute(f"EXPLAIN QUERY PLAN {statement}", values)
                plans.extend(str(row[3]) for row in plan)
            return execute(statement, values)

        database._file.execute = explained  # type: ignore[method-assign]
        ask(database, 3)
        database.record(recording(squat(3)))
        with pytest.raises(EntryNotFound):
            ask(database, 11, kind="learned")
    assert plans
    assert [plan for plan in plans if plan.startswith("SCAN") and "CONSTANT" not in plan] == []


def test_generalising_decodes_entries_once_and_fits_once(
    tmp_path: Path, decoded: list[type[Row]], monkeypatch: pytest.MonkeyPatch
) -> None:
    fits: list[int] = []

    class Counted(WeightRegression):
        def __init__(self, *arguments: Any) -> None:
            fits.append(1)
            super().__init__(*arguments)

    monkeypatch.setattr(entry_regression, "WeightRegression", Counted)
    fill(tmp_path / "d.sqlite", 12)
    between = {"amplitude": 0.01, "frequency": 0.1055}
    with Database(tmp_path / "d.sqlite") as database, Database(tmp_path / "d.sqlite") as other:
        first = database.query("squat", robot=ROBOT, **between)
        assert decoded.count(IterationRow) == 24
        decoded.clear()
        again = database.query("squat", robot=ROBOT, **between)
        assert (decoded, len(fits)) == ([], 1)
        np.testing.assert_array_equal(first.weights, again.weights)
        # another connection changes one of them: that one is decoded, and fitted anew
        entry, _ = other.record(recording(squat(5)))
        decoded.clear()
        database.query("squat", robot=ROBOT, **between)
        assert decoded.count(IterationRow) == 2
        assert entry.identifier == 5


@pytest.mark.parametrize("kind", [None, "generalised"])
def test_too_many_entries_are_not_compared(
    path: Path, monkeypatch: pytest.MonkeyPatch, kind: str | None
) -> None:
    between = {"amplitude": 0.01, "frequency": 0.1055}
    for most, refused in ((10, False), (9, True)):
        monkeypatch.setattr("tsd_casadi.database.answers.MOST_ENTRIES", most)
        with Database(path) as database:
            assert ask(database, 3).kind == "learned"
            if not refused:
                assert database.query("squat", robot=ROBOT, kind=kind, **between).weights.any()
                continue
            with pytest.raises(InvalidValue, match="at most 9"):
                database.query("squat", robot=ROBOT, kind=kind, **between)
            with pytest.raises(InvalidValue, match="at most 9"):
                database.suggest("squat", robot=ROBOT, region={"amplitude": (0.01, 0.02)})


def test_an_error_names_some_entries_and_counts_the_others(path: Path) -> None:
    fill_more = [recording(squat(number)) for number in (11, 12)]
    with Database(path) as database:
        with pytest.raises(EntryNotFound, match=r"frequency=0\.11 height=0\. Learn"):
            ask(database, 500, kind="learned")
        for made in fill_more:
            database.record(made)
        with pytest.raises(EntryNotFound, match=r"height=0 and 2 more\. Learn it"):
            ask(database, 500, kind="learned")


def test_kept_entries_are_bounded(path: Path) -> None:
    kept = KeptEntries()
    with Database(path) as database:
        (entry, *_) = database.entries()
    for event in range(KEPT_ENTRIES + 1):
        kept.keep(event, entry)
    assert kept.find(1, 0) is None
    assert kept.find(1, 1) is kept.find(1, KEPT_ENTRIES) is entry


def test_an_answer_may_be_changed_without_harm(path: Path) -> None:
    with Database(path) as database:
        before = ask(database, 3)
        weights = before.weights.copy()
        before.weights[:] = 7.0
        before.provenance["gains"]["P"].append(1.0)
        after = ask(database, 3)
    np.testing.assert_array_equal(after.weights, weights)
    assert after.provenance["gains"]["P"] == [50.0] * 3


# the derived tables


@given(
    st.dictionaries(
        st.from_regex(r"[A-Za-z][A-Za-z0-9_.]{0,9}", fullmatch=True),
        st.floats(-1e6, 1e6) | st.integers(-1_000_000, 1_000_000),
        max_size=5,
    )
)
def test_parameters_are_the_same_text_here_and_in_the_file(given: dict[str, float]) -> None:
    key = EntryKey.of("r", "m", "1", ("com.z",), given)
    expression = derived._PLACE.replace("entry.parameters", ":text")
    with closing(sqlite3.connect(":memory:")) as plain:
        text = {"text": json.dumps(dict(key.parameters))}
        (found,) = plain.execute(f"SELECT {expression}", text).fetchone()
    assert found == place(key.parameters)


def test_a_file_without_the_index_gets_it_at_opening(path: Path) -> None:
    """As older software of the same schema version left it."""
    with closing(sqlite3.connect(path)) as plain:
        kinds = dict(plain.execute("SELECT name, type FROM sqlite_master"))
        for name in reversed(derived._DERIVED):
            plain.execute(f"DROP {kinds[name]} IF EXISTS {name}")
        plain.commit()
        left = {row[0] for row in plain.execute("SELECT name FROM sqlite_master")}
    assert not left & set(derived._DERIVED)
    with Database(path) as database:
        assert ask(database, 7).kind == "learned"
        assert database.verify() == []
        assert database.state().entries == 10


def test_an_index_of_another_version_is_made_anew(path: Path) -> None:
    with closing(sqlite3.connect(path)) as plain:
        plain.execute("DROP INDEX entry_state_place")
        plain.execute("CREATE INDEX entry_state_place ON entry_state (place)")
        plain.execute("UPDATE entry_state SET place = 'elsewhere'")
        plain.commit()
    with Database(path) as database:
        assert ask(database, 7).kind == "learned"
        assert database.verify() == []


def test_rows_of_older_software_are_in_the_index_too(path: Path) -> None:
    with Database(path) as database, closing(sqlite3.connect(path)) as older:
        older.execute(
            "INSERT INTO event SELECT 11, entry, 'forgotten', time, body, formulation, correction, "
            "declaration, circumstances, rule, learning_gain, checksum FROM event WHERE id = 3"
        )
        older.commit()
        with pytest.raises(EntryNotFound):
            ask(database, 3, kind="learned")
        assert database.state().entries == 9


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE entry_state SET place = 'amplitude=1' WHERE entry = 3",
        "UPDATE entry_state SET body = 'beef' WHERE entry = 3",
        "DELETE FROM entry_state WHERE entry = 3",
        "UPDATE entry_count SET entries = 11",
        "DELETE FROM entry_count",
    ],
)
def test_an_index_that_does_not_fit_the_rows_is_told(path: Path, damage: str) -> None:
    with closing(sqlite3.connect(path)) as plain:
        plain.execute(damage)
        plain.commit()
    with Database(path) as database:
        assert any("index" in finding for finding in database.verify())


def test_an_index_that_names_the_wrong_entry_serves_nothing_wrong(path: Path) -> None:
    with closing(sqlite3.connect(path)) as plain:
        plain.execute(
            "UPDATE entry_state SET place = (SELECT place FROM entry_state WHERE entry = 4) "
            "WHERE entry = 3"
        )
        plain.execute("DELETE FROM entry_state WHERE entry = 4")
        plain.commit()
    with Database(path) as database:
        with pytest.raises(DatabaseError, match="damaged entry 3"):
            ask(database, 4)
        assert database.state().damaged == 1


def test_a_damaged_entry_blocks_no_other_context(path: Path) -> None:
    with closing(sqlite3.connect(path)) as plain:
        plain.execute("DROP TRIGGER entry_UPDATE")
        plain.execute("UPDATE entry SET parameters = '5' WHERE id = 3")
        plain.commit()
    with Database(path) as database:
        for number in range(1, 11):
            if number != 3:
                assert ask(database, number).kind == "learned"
        assert database.query("squat", robot=ROBOT, amplitude=0.01, frequency=0.1055).weights.any()


# other writers and full disks


def test_readers_see_what_others_wrote_and_never_half_of_it(path: Path) -> None:
    with Database(path) as writer, Reading(path) as reader:
        before = reader.version()
        ask(reader, 3)
        assert reader.version() == before
        with writer._file.transaction("IMMEDIATE"):
            writer._new_rows.forget(3, "now")
            assert ask(reader, 3).kind == "learned"
        assert reader.version() != before
        with pytest.raises(EntryNotFound):
            ask(reader, 3, kind="learned")


def test_what_only_reads_cannot_write(path: Path) -> None:
    with Database(path), Reading(path) as reader, pytest.raises(DatabaseError, match="readonly"):
        reader._file.execute("DELETE FROM entry_count")


def test_a_full_disk_is_named_and_nothing_is_lost(path: Path) -> None:
    with Database(path) as database, Reading(path) as reader:
        (pages,) = database._file.execute("PRAGMA page_count")[0]
        database._file.execute(f"PRAGMA max_page_count = {pages}")
        with pytest.raises(DatabaseError, match=r"disk is full.*check free disk space"):
            for number in range(11, 200):
                database.record(recording(squat(number)))
        kept = len(reader.entries())
        assert ask(reader, 3).kind == "learned"
        assert ask(database, 3).kind == "learned"
        database._file.execute("PRAGMA max_page_count = 1000000")
        database.record(recording(squat(500)))
        assert len(reader.entries()) == kept + 1
        assert database.verify() == []


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    folder = tmp_path / "small"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("a small disk needs root")
    yield folder
    subprocess.run(["umount", "-l", str(folder)], check=True)


def test_a_disk_that_is_full_or_read_only_keeps_nobody_from_asking(small_disk: Path) -> None:
    path = small_disk / "d.sqlite"
    fill(path, 10)
    with Database(path) as database, Reading(path) as reader:
        answered = 10
        with pytest.raises(DatabaseError, match="full"):
            for number in range(11, 2000):
                database.record(recording(squat(number)))
                answered += 1
        assert ask(reader, 3).kind == "learned"
        assert len(reader.outlines().entries) == answered > 10
        assert database.verify() == []
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    with pytest.raises(DatabaseError, match="readonly"):
        Database(path)


def test_a_file_that_became_read_only_goes_on_answering(path: Path) -> None:
    with Database(path) as database:
        database._file.execute("PRAGMA query_only = ON")
        with pytest.raises(DatabaseError, match=r"readonly.*check free disk space, permissions"):
            database.record(recording(squat(11)))
        assert ask(database, 3).kind == "learned"
        database._file.execute("PRAGMA query_only = OFF")
        assert database.record(recording(squat(11)))[0].identifier == 11


def test_an_import_beside_a_learner_keeps_both(path: Path, tmp_path: Path) -> None:
    fill(tmp_path / "other.sqlite", 60)
    with Database(tmp_path / "other.sqlite") as other:
        other.export(tmp_path / "other.json")
    problems: list[BaseException] = []

    def take_in() -> None:
        try:
            with Database(path) as second:
                assert second.import_(tmp_path / "other.json").added == 50
        except BaseException as error:
            problems.append(error)

    with Database(path) as learner:
        thread = threading.Thread(target=take_in)
        thread.start()
        for number in range(101, 121):
            learner.record(recording(squat(number)))
            assert ask(learner, 3).kind == "learned"
        thread.join()
        assert problems == []
        assert learner.state().entries == 80
        assert learner.verify() == []


def test_recordings_that_fill_a_database_are_plausible_at_every_frequency(tmp_path: Path) -> None:
    with Database(tmp_path / "some.sqlite") as database:
        for number in (1, 500, 999, 100_000):
            database.record(recording(squat(number)))
