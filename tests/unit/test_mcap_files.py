"""Files of logs as MCAP: whole, cut, converted, killed."""

from __future__ import annotations

import dataclasses
import io
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader

from tsd_casadi import InverseDynamics, Robot
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.exceptions.logs import LogNotWhole
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.logs.convert_log import write_any_log
from tsd_clients.logs.copy_mcap import copy_mcap
from tsd_clients.logs.cut_log import cut_log, part_of, ticks_between, ticks_of_laps
from tsd_clients.logs.log import Log
from tsd_clients.logs.mcap_file import TICK_TOPIC, begin_mcap
from tsd_clients.logs.mcap_recording import McapRecording
from tsd_clients.logs.read_log import read_log
from tsd_clients.logs.recover_log import recover_log
from tsd_clients.logs.run_summary import KILLED
from tsd_clients.logs.tick_columns import tick_columns

LAP, TICKS = 30, 120
BEGAN = 1_700_000_000_123_456_789
few = settings(
    max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@pytest.fixture(scope="module")
def outline(mini_biped: Robot) -> RunOutline:
    axes = ("mass.z", "mass.x")
    return RunOutline(
        robot=mini_biped.name,
        robot_file=str(mini_biped.path),
        model=mini_biped.fingerprint,
        motion="squat",
        version="1",
        parameters={"amplitude": 0.03},
        axes=axes,
        learned=1,
        period=1e-3,
        nq=mini_biped.nq,
        torque_limits=tuple(map(float, mini_biped.torque_limit)),
        controller=InverseDynamics(mini_biped).format.plain(),
    )


@pytest.fixture(scope="module")
def rows(outline: RunOutline, mini_biped: Robot) -> np.ndarray:
    """A lap of holding and three laps; one period without an answer, one tick infeasible."""
    layout = outline.layout
    rows = np.random.default_rng(0).normal(size=(TICKS, layout.size))
    reply = layout.slice("reply").start
    known = outline.known.reply
    active = slice(reply + known.slice("active").start, reply + known.slice("active").stop)
    for name, values in (
        ("time", 1e-3 * np.arange(TICKS)),
        ("lap", np.arange(TICKS) // LAP - 1),
        ("missed", np.arange(TICKS) == 50),
        ("share", np.ones(TICKS)),
    ):
        rows[:, layout.slice(name).start] = values
    for name in ("q", "true_q"):
        rows[:, layout.slice(name)] = mini_biped.home.q
    rows[:, reply] = np.arange(TICKS) == 70
    rows[:, active] = 0
    rows[50, layout.slice("reply")] = np.nan
    return rows


@pytest.fixture(scope="module")
def content(outline: RunOutline, rows: np.ndarray) -> bytes:
    """A whole file; its second and third lap are measured."""
    file = io.BytesIO()
    recording = McapRecording(begin_mcap(file), outline, BEGAN)
    for start in range(0, TICKS, 7):
        recording.add_ticks(tick_columns(rows[start : start + 7], outline))
        if start == 70:
            recording.add_request(np.arange(3.0).tobytes())
    recording.finish({"measured_s": [2 * LAP * 1e-3, (TICKS - 1) * 1e-3], "feedforward": "none"})
    return file.getvalue()


@pytest.fixture
def path(content: bytes, tmp_path: Path) -> Path:
    (tmp_path / "run.mcap").write_bytes(content)
    return tmp_path / "run.mcap"


def assert_same(found: Log, expected: Log) -> None:
    assert (found.axes, found.outline, found.summary) == (
        expected.axes,
        expected.outline,
        expected.summary,
    )
    for name, values in {**expected.fields, **expected.more}.items():
        got = {**found.fields, **found.more}[name]
        np.testing.assert_array_equal(got, values, err_msg=name)
        assert got.dtype == values.dtype
    np.testing.assert_array_equal(found.infeasible_request, expected.infeasible_request)


def test_a_log_comes_back_in_every_digit(path: Path, outline: RunOutline, rows: np.ndarray) -> None:
    log, columns = read_log(path), tick_columns(rows, outline)
    assert log.fields.keys() == LOG_FIELDS.keys()
    for name, field in LOG_FIELDS.items():
        if name != "measured":
            expected = columns[name].astype(field.type)
            np.testing.assert_array_equal(log.fields[name], expected, err_msg=name)
    measured = (np.arange(TICKS) >= 2 * LAP) & (log.fields["missed"] == 0)
    np.testing.assert_array_equal(log.fields["measured"], measured)
    np.testing.assert_array_equal(log.infeasible_request, np.arange(3.0))
    assert log.fields["status"][50] == -1 and np.isnan(log.fields["error"][50]).all()
    error = columns["error"][measured][:, 0]
    assert log.errors["mass.z"].rms == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)


@few
@given(first=st.integers(0, TICKS - 1), last=st.integers(0, TICKS - 1))
def test_formats_and_cuts_commute(path: Path, first: int, last: int) -> None:
    first, last = sorted((first, last))
    log = read_log(path)
    ticks = ticks_between(log, 1e-3 * first - 1e-6, 1e-3 * last + 1e-6)
    assert ticks.sum() == last - first + 1
    expected = part_of(log, ticks)
    with TemporaryDirectory() as folder:
        cut, npz, again = (Path(folder) / name for name in ("a.mcap", "b.npz", "c.mcap"))
        cut_log(path, cut, log, ticks)
        assert_same(read_log(cut), expected)
        write_any_log(read_log(cut), npz)
        assert_same(read_log(npz), expected)
        write_any_log(read_log(npz), again)
        found = read_log(again)
        assert_same(found, expected)
        lines = Path(folder) / "d.csv"
        write_any_log(expected, lines)
        for name, values in expected.fields.items():
            np.testing.assert_array_equal(read_log(lines).fields[name], values, err_msg=name)


def test_laps_are_cut_whole(path: Path) -> None:
    log = read_log(path)
    assert ticks_of_laps(log, 1, 2).sum() == 2 * LAP
    with pytest.raises(InvalidValue, match=r"part of 0\.000 to 0\.119 s, laps -1 to 2"):
        cut_log(path, path.with_name("no.mcap"), log, ticks_of_laps(log, 7, 8))
    assert not path.with_name("no.mcap").exists()


def test_without_an_outline_there_is_no_mcap(path: Path) -> None:
    log = dataclasses.replace(read_log(path), outline=None)
    with pytest.raises(InvalidValue, match="columns only"):
        write_any_log(log, path.with_name("no.mcap"))


def ticks_of_whole_chunks(content: bytes, size: int) -> int:
    """Count with the reader of mcap what a beginning of a file has."""
    summary = make_reader(io.BytesIO(content)).get_summary()
    assert summary is not None
    (topic,) = (each.id for each in summary.channels.values() if each.topic == TICK_TOPIC)
    ends = [each.chunk_start_offset + each.chunk_length for each in summary.chunk_indexes]
    end = max((each for each in ends if each <= size), default=8)
    messages = []
    with suppress(EndOfFile):
        for record in StreamReader(io.BytesIO(content[:end]), validate_crcs=True).records:
            messages.append(record)
    return sum(isinstance(each, Message) and each.channel_id == topic for each in messages)


@few
@given(st.floats(0.0, 1.0, exclude_max=True))
def test_killed_at_any_byte_all_but_the_last_chunk_comes_back(path: Path, share: float) -> None:
    """A writer that is killed leaves a beginning of what it would have written."""
    content, whole = path.read_bytes(), read_log(path)
    # from where the file says what it is of
    first = content.index(b"outline.json") + len(whole.outline.encode()) + 200
    size = int(first + share * (len(content) - first))
    with TemporaryDirectory() as folder:
        killed = Path(folder) / "killed.mcap"
        killed.write_bytes(content[:size])
        with pytest.raises(LogNotWhole, match="tsd log recover"):
            read_log(killed)
        copied = recover_log(killed, killed)
        found = read_log(killed)
    assert found.ticks == copied.ticks == ticks_of_whole_chunks(content, size)
    if "measured_s" not in found.summary:
        assert found.summary == {"aborted": KILLED}
    for name in LOG_FIELDS.keys() - {"measured"}:
        np.testing.assert_array_equal(found.fields[name], whole.fields[name][: found.ticks])


def test_a_damaged_chunk_costs_itself_only(content: bytes, tmp_path: Path) -> None:
    damaged = bytearray(content)
    middle = content.index(b"zstd", len(content) // 2) + 100
    damaged[middle : middle + 4] = b"\0\0\0\0"
    path = tmp_path / "run.mcap"
    path.write_bytes(damaged)
    with pytest.raises(LogNotWhole, match="not whole"):
        read_log(path)
    copied = recover_log(path, tmp_path / "recovered.mcap")
    assert copied.is_whole and copied.damaged == 1
    log = read_log(tmp_path / "recovered.mcap")
    assert 0 < log.ticks == copied.ticks < TICKS
    assert log.fields["time"][0] == 0 and log.fields["time"][-1] == 1e-3 * (TICKS - 1)


def test_a_whole_file_is_left_as_it_is(path: Path, content: bytes) -> None:
    copied = recover_log(path, path)
    assert copied.is_whole and copied.ticks == TICKS
    assert path.read_bytes() == content


@pytest.mark.parametrize("start", [b"", b"no log", b"\x89MCAP0\r\n"])
def test_what_has_no_beginning_is_refused_and_kept(tmp_path: Path, start: bytes) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(start)
    with pytest.raises(InvalidValue, match="beginning"):
        recover_log(path, path)
    assert path.read_bytes() == start


def test_other_files_are_not_recovered(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match="whole or not at all"):
        recover_log(tmp_path / "run.npz", tmp_path / "run.npz")


def test_zeros_behind_the_end_are_no_records(content: bytes) -> None:
    """As a file system leaves them where a file grew before its content was there."""
    half = content[: len(content) // 2]
    with_zeros, without = (
        copy_mcap(io.BytesIO(each), begin_mcap(io.BytesIO())) for each in (half + bytes(5000), half)
    )
    assert with_zeros.ticks == without.ticks > 0
