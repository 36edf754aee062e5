import inspect
import json
import os
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zenoh

from benchmarks.filled_database import fill
from tsd_casadi.database.database import Database
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import (
    DatabaseError,
    EntryNotFound,
    InvalidValue,
    OutsideTrainedRange,
    ServiceNotReady,
    ServiceUnreachable,
    TsdError,
    TwoServices,
)
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.motions.squat import Squat
from tsd_casadi.wire.error import ErrorMessage
from tsd_casadi.wire.keys import feedforward_key, record_key, suggestion_key
from tsd_casadi.wire.learner import DatabaseReply
from tsd_casadi.wire.record import RecordMessage
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_server.service_process import ServiceProcess, free_endpoint

EXAMPLES = Path(__file__).parents[2] / "examples"
ROBOT = "hermes_lower"
CONTEXT = Context("00ff", "abcd")
MADE = Circumstances({"P": [50.0], "D": [14.0]}, {"seed": 0}, "test")


def recording_of(amplitude: float, error: float = 0.01) -> Recording:
    basis = PeriodicBasis()
    phase = np.linspace(0, 2 * np.pi, 500, endpoint=False)
    feedback = -0.7 + amplitude * np.sin(phase) + 3 * amplitude**2 * np.cos(2 * phase)
    return Recording(
        key=EntryKey.of(
            ROBOT,
            "squat",
            Squat.version,
            ("com.z",),
            {"amplitude": amplitude, "frequency": 0.25},
            CONTEXT,
        ),
        basis=basis,
        applied=np.zeros((1, basis.L)),
        laps=[Lap(phase, feedback[None, :])] * 2,
        errors={"com.z": AxisError(error, ac_rms=error / 10)},
        circumstances=MADE,
        declaration=Squat.declaration(),
    )


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("learner") / "test.sqlite"


@pytest.fixture(scope="module")
def endpoint(database: Path) -> Iterator[str]:
    endpoint = free_endpoint()
    with ServiceProcess(["learner", "--database", str(database), "--listen", endpoint]):
        with RemoteLearner([endpoint]) as learner:
            for amplitude in (0.02, 0.04, 0.06, 0.08):
                learner.record(recording_of(amplitude))
        yield endpoint


@pytest.fixture
def learner(endpoint: str) -> Iterator[RemoteLearner]:
    with RemoteLearner([endpoint]) as learner:
        yield learner


def ask(session: zenoh.Session, selector: str, payload: bytes | None = None) -> zenoh.Reply:
    return next(iter(session.get(selector, payload=payload, timeout=10.0)))


def test_learned_and_generalised(learner: RemoteLearner) -> None:
    exact = learner.query("squat", robot=ROBOT, amplitude=0.04, frequency=0.25)
    assert exact.kind == "learned"
    assert exact.iteration == 1
    between = learner.query("squat", robot=ROBOT, amplitude=0.05, frequency=0.25)
    assert between.kind == "generalised"
    assert between.provenance["entries"] == [1, 2, 3, 4]
    phase = np.linspace(0, 6, 50)
    truth = -0.7 + 0.05 * np.sin(phase) + 3 * 0.05**2 * np.cos(2 * phase)
    # the basis itself represents a sine to 3e-4
    np.testing.assert_allclose(between.mean(phase)[0], truth, atol=5e-4)


def test_stock_client_rebuilds_the_same_samples(learner: RemoteLearner, endpoint: str) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / "query_feedforward.py"), endpoint],
        capture_output=True,
        text=True,
        timeout=60,
        env={**os.environ, "PYTHONPATH": ""},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    reply = json.loads(done.stdout)
    assert reply["kind"] == "generalised"
    assert reply["parameters"]["amplitude"] == {"value": 0.05, "unit": "m"}
    phase = np.linspace(0, 2 * np.pi, 333)
    centres, width = np.array(reply["basis"]["centres"]), reply["basis"]["width"]
    gamma = np.exp(width * (np.cos(phase[:, None] - centres) - 1))
    samples = (gamma @ np.array(reply["weights"]).T / gamma.sum(axis=1, keepdims=True)).T
    ours = learner.query("squat", robot=ROBOT, amplitude=0.05, frequency=0.25).mean(phase)
    np.testing.assert_allclose(samples, ours, rtol=0, atol=1e-12)


def test_stock_example_is_ten_lines_of_zenoh_alone() -> None:
    lines = (EXAMPLES / "query_feedforward.py").read_text().splitlines()
    code = [line for line in lines if line and not line.startswith(('"""', "#"))]
    assert len(code) <= 10
    imports = {line.split()[1] for line in code if line.startswith(("import", "from"))}
    assert imports == {"json", "sys", "zenoh"}


@pytest.mark.parametrize(
    ("parameters", "code"),
    [
        ("", "malformed"),
        ("?motion=squat", "invalid_value"),
        ("?motion=squat;frequency=0.25", "invalid_value"),
        ("?task=squat;amplitude=0.05;frequency=0.25", "version"),
        ("?motion=squat;amplitude=0.05;axes=com.z,com.z", "invalid_value"),
        ("?motion=squat;amplitude=0.05;axes=com.x", "not_found"),
        ("?motion=squat;amplitude=0.05;body=00ff", "invalid_value"),
        ("?motion=squat;amplitude=0.05;body=beef;formulation=abcd", "not_found"),
        ("?motion=squat;amplitude=0.05;version=none", "not_found"),
        ("?motion=squat;amplitude=x;frequency=0.25", "invalid_value"),
        ("?motion=squat;amplitude=nan;frequency=0.25", "invalid_value"),
        ("?motion=squat;amplitude=-1;frequency=0.25", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;colour=red", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;colour=1", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;robot=1", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;region=1", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;self=1", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;height=inf", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;height=high", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;height=-0.01", "not_found"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;kind=best", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;extrapolate=maybe", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25;kind=learned", "not_found"),
        ("?motion=jump;amplitude=0.05;frequency=0.25", "not_found"),
        ("?motion=squat;amplitude=0.05;frequency=0.5", "not_found"),
        ("?motion=squat;amplitude=0.2;frequency=0.25", "extrapolation"),
    ],
)
def test_bad_query_is_an_error_with_a_code(
    raw_session: zenoh.Session, parameters: str, code: str
) -> None:
    reply = ask(raw_session, feedforward_key(ROBOT) + parameters)
    assert reply.err is not None
    assert ErrorMessage.decode(reply.err.payload.to_bytes()).code == code


@pytest.mark.parametrize(
    ("parameters", "code"),
    [
        ("", "malformed"),
        ("?motion=squat", "invalid_value"),
        ("?motion=squat;amplitude=0.05;frequency=0.25", "invalid_value"),
        ("?motion=squat;frequency=0.2:0.6", "invalid_value"),
        ("?task=squat;amplitude=0.02:0.08;frequency=0.25", "version"),
        ("?motion=squat;amplitude=0.02:;frequency=0.25", "invalid_value"),
        ("?motion=squat;amplitude=0.02:0.04:0.08;frequency=0.25", "invalid_value"),
        ("?motion=squat;amplitude=0.08:0.02;frequency=0.25", "invalid_value"),
        ("?motion=squat;amplitude=0.02:nan;frequency=0.25", "invalid_value"),
        ("?motion=squat;amplitude=-0.02:0.08;frequency=0.25", "invalid_value"),
        ("?motion=squat;amplitude=0.02:0.08;frequency=0.25;colour=0:1", "invalid_value"),
        ("?motion=squat;amplitude=0.02:0.08;frequency=0.25;robot=0:1", "invalid_value"),
        ("?motion=squat;amplitude=0.02:0.08;frequency=0.25;self=0:1", "invalid_value"),
        ("?motion=squat;amplitude=0.02:0.08;frequency=0.25;extrapolate=true", "invalid_value"),
    ],
)
def test_bad_region_is_an_error_with_a_code(
    raw_session: zenoh.Session, parameters: str, code: str
) -> None:
    reply = ask(raw_session, suggestion_key(ROBOT) + parameters)
    assert reply.err is not None
    assert ErrorMessage.decode(reply.err.payload.to_bytes()).code == code


def test_nobody_suggests_for_any_robot(raw_session: zenoh.Session) -> None:
    reply = ask(
        raw_session, suggestion_key("*") + "?motion=squat;amplitude=0.02:0.08;frequency=0.25"
    )
    assert reply.err is not None
    assert ErrorMessage.decode(reply.err.payload.to_bytes()).code == "malformed"


def test_a_suggestion_is_the_databases(learner: RemoteLearner, database: Path) -> None:
    region = {"amplitude": (0.02, 0.08)}
    found = learner.suggest("squat", robot=ROBOT, region=region, frequency=0.25)
    with Database(database) as opened:
        assert found == opened.suggest("squat", robot=ROBOT, region=region, frequency=0.25)
    assert found.standard_deviation is not None
    assert 0.02 <= found.parameters["amplitude"] <= 0.08
    assert (found.parameters["frequency"], found.parameters["height"]) == (0.25, 0.0)


def test_a_suggestion_for_an_unknown_robot_is_the_middle(learner: RemoteLearner) -> None:
    region = {"amplitude": (0.02, 0.08), "height": (-0.04, 0.02)}
    found = learner.suggest("squat", robot="another", region=region, frequency=0.25)
    assert found.parameters == {"amplitude": 0.05, "frequency": 0.25, "height": -0.01}
    assert found.standard_deviation is None


def test_numbers_of_numpy_are_numbers(learner: RemoteLearner) -> None:
    low, asked, high = np.linspace(0.02, 0.08, 3)
    found = learner.query("squat", robot=ROBOT, amplitude=asked, frequency=np.float64(0.25))
    assert found.parameters["amplitude"] == pytest.approx(0.05)
    region = {"amplitude": (low, high)}
    place = learner.suggest("squat", robot=ROBOT, region=region, frequency=np.float64(0.25))
    assert 0.02 <= place.parameters["amplitude"] <= 0.08


def test_height_may_be_left_out_and_may_be_negative(learner: RemoteLearner) -> None:
    squat = {"amplitude": 0.04, "frequency": 0.25}
    here = learner.query("squat", robot=ROBOT, **squat)
    assert learner.query("squat", robot=ROBOT, **squat, height=0.0).parameters == here.parameters
    assert here.parameters["height"] == 0.0
    with pytest.raises(EntryNotFound, match=r"every learned squat has height 0 m"):
        learner.query("squat", robot=ROBOT, **squat, height=-0.01)


@pytest.mark.parametrize("payload", [None, b"", b"{", b"[]", b'{"format": "squat"}', b"\xff\xfe"])
def test_bad_recording_is_refused_and_nothing_lost(
    raw_session: zenoh.Session, learner: RemoteLearner, payload: bytes | None
) -> None:
    before = learner.database().entries
    reply = ask(raw_session, record_key(ROBOT), payload)
    assert reply.err is not None
    assert ErrorMessage.decode(reply.err.payload.to_bytes()).code == "malformed"
    assert learner.database().entries == before


@pytest.mark.parametrize("number", ["x", "-1", "1.5", "²", "٣", "1" * 5000])
def test_what_is_no_number_of_an_entry_is_refused(raw_session: zenoh.Session, number: str) -> None:
    reply = ask(raw_session, f"tsd/*/learner/database?forget={number}")
    assert reply.err is not None
    assert ErrorMessage.decode(reply.err.payload.to_bytes()).code == "invalid_value"


@pytest.mark.parametrize("key", ["**", "tsd/**", "tsd/$*lower/learner/database"])
def test_a_key_for_more_than_one_question_is_refused(raw_session: zenoh.Session, key: str) -> None:
    reply = ask(raw_session, key)
    assert reply.err is not None
    assert ErrorMessage.decode(reply.err.payload.to_bytes()).code in ("malformed", "invalid_value")


def test_a_recording_of_version_1_is_told_what_to_send(raw_session: zenoh.Session) -> None:
    old = {"task": "squat", "axes": ["com.z"], "parameters": {}, "laps": []}
    reply = ask(raw_session, record_key(ROBOT), json.dumps(old).encode())
    assert reply.err is not None
    # as a client of version 1 reads it
    body = json.loads(reply.err.payload.to_bytes())
    assert body.keys() == {"code", "message"}
    assert body["code"] == "version"
    assert "tsd.record/2" in body["message"]


def test_a_query_without_a_context_names_the_newest_and_counts_the_others(
    learner: RemoteLearner,
) -> None:
    elsewhere = Context("beef", "abcd", "c0ffee")
    made = recording_of(0.033)
    made = replace(made, key=replace(made.key, context=elsewhere))
    entry, _ = learner.record(made)
    try:
        message = learner.query_message("squat", robot=ROBOT, amplitude=0.033)
        assert message.context.context() == elsewhere
        assert (message.others, message.instance > 0) == (4, True)
        assert message.declaration is not None
        found = learner.query("squat", robot=ROBOT, context=CONTEXT, amplitude=0.033)
        assert (found.kind, found.provenance["others"]) == ("generalised", 1)
        place = learner.suggest(
            "squat", robot=ROBOT, region={"amplitude": (0.02, 0.08)}, context=CONTEXT
        )
        assert place.standard_deviation is not None
        (only,) = [each for each in learner.entries(ROBOT) if each.entry == entry.entry]
        assert only.context.context() == elsewhere
    finally:
        learner.forget(entry.entry)


def test_an_entry_for_fewer_axes_serves_a_run_of_more(learner: RemoteLearner) -> None:
    found = learner.query("squat", robot=ROBOT, axes=("com.x", "com.z"), amplitude=0.04)
    assert (found.kind, found.axes, found.provenance["axes"]) == ("learned", ("com.z",), ["com.z"])


@pytest.mark.parametrize("name", ["query", "suggest", "record", "entries"])
def test_a_local_database_is_asked_as_a_remote_learner_is(name: str) -> None:
    local, remote = (
        inspect.signature(getattr(kind, name)).parameters for kind in (Database, RemoteLearner)
    )
    assert list(local) == list(remote)
    for parameter, expected in remote.items():
        assert local[parameter].kind == expected.kind
        # which robot is meant may be left out locally while there is only one
        assert parameter == "robot" or local[parameter].default == expected.default


def test_unknown_key_is_refused(raw_session: zenoh.Session) -> None:
    reply = ask(raw_session, f"tsd/{ROBOT}/learner/nonsense")
    assert reply.err is not None
    assert ErrorMessage.decode(reply.err.payload.to_bytes()).code == "malformed"


@pytest.mark.parametrize(
    ("kind", "motion", "options"),
    [
        (EntryNotFound, "squat", {"amplitude": 0.043, "kind": "learned"}),
        (OutsideTrainedRange, "squat", {"amplitude": 0.5}),
        (InvalidValue, "squat", {"amplitude": -0.05}),
        (InvalidValue, "squat", {}),
        (InvalidValue, "squat", {"amplitude": 0.05, "nonsense": 1.0}),
        (EntryNotFound, "somersault", {"amplitude": 0.05}),
    ],
)
def test_a_refusal_is_the_same_error_here_and_there(
    learner: RemoteLearner,
    database: Path,
    kind: type[TsdError],
    motion: str,
    options: dict[str, Any],
) -> None:
    with pytest.raises(kind) as there:
        learner.query(motion, robot=ROBOT, frequency=0.25, **options)
    with Database(database) as local, pytest.raises(kind) as here:
        local.query(motion, robot=ROBOT, frequency=0.25, **options)
    assert type(there.value) is type(here.value) is kind
    assert str(there.value) == str(here.value)
    assert vars(there.value) == vars(here.value)


def test_extrapolation_on_request(learner: RemoteLearner) -> None:
    outside = {"amplitude": 0.09, "frequency": 0.25}
    with pytest.raises(OutsideTrainedRange, match="extrapolate=true"):
        learner.query("squat", robot=ROBOT, **outside)
    far = learner.query("squat", robot=ROBOT, extrapolate=True, **outside)
    near = learner.query("squat", robot=ROBOT, amplitude=0.07, frequency=0.25)
    assert far.standard_deviations.mean() > near.standard_deviations.mean()


def test_stable_learning_over_the_network_is_that_of_a_local_database(
    learner: RemoteLearner, tmp_path: Path
) -> None:
    phase = np.linspace(0, 2 * np.pi, 500, endpoint=False)
    applied = np.zeros((1, PeriodicBasis().L))
    with Database(tmp_path / "local.sqlite") as database:
        for rms_error in (2e-3, 0.5e-3):
            error = rms_error * (1 + 0.5 * np.cos(2 * phase))[None, :]
            lap = Lap(phase, 50 * error, error, 0.035 * np.sin(phase)[None, :])
            made = replace(
                recording_of(0.035, rms_error),
                applied=applied,
                laps=[lap],
            )
            there, _ = learner.record(made, Instruction(find_rule("stable")))
            here, _ = database.record(made, Instruction(find_rule("stable")))
            applied = here.served.weights
        asked = learner.query("squat", robot=ROBOT, amplitude=0.035, frequency=0.25)
    np.testing.assert_allclose(asked.weights, applied, rtol=0, atol=1e-12)
    assert there.rule == "stable"
    assert there.contractions == here.contractions
    assert here.contractions[0].observed[2] is not None
    learner.forget(there.entry)


def test_a_stable_recording_without_positions_is_refused(learner: RemoteLearner) -> None:
    # a client of another language: this one refuses by itself
    message = RecordMessage.of(recording_of(0.035)).model_copy(update={"rule": "stable"})
    with pytest.raises(InvalidValue, match="without error and reference"):
        learner._session.query_one(record_key(ROBOT), payload=message.encode())


def test_forget(learner: RemoteLearner) -> None:
    entry, _ = learner.record(recording_of(0.07))
    reply = learner.forget(entry.entry)
    assert reply.forgotten is not None
    assert reply.forgotten.entry == entry.entry
    assert entry.entry not in [left.entry for left in reply.entries]
    with pytest.raises(EntryNotFound, match="no entry"):
        learner.forget(entry.entry)


def test_what_was_recorded_survives_a_killed_service(tmp_path: Path) -> None:
    arguments = ["learner", "--database", str(tmp_path / "a.sqlite"), "--listen", free_endpoint()]
    with ServiceProcess(arguments) as service:
        with RemoteLearner([arguments[-1]]) as learner:
            learner.record(recording_of(0.03))
        service.process.send_signal(signal.SIGKILL)
        service.process.wait()
    with ServiceProcess(arguments), RemoteLearner([arguments[-1]]) as learner:
        found = learner.query("squat", robot=ROBOT, amplitude=0.03, frequency=0.25)
        assert found.kind == "learned"


def test_who_asks_does_not_wait_for_who_writes(tmp_path: Path) -> None:
    path, endpoint = tmp_path / "a.sqlite", free_endpoint()
    with (
        ServiceProcess(["learner", "--database", str(path), "--listen", endpoint]),
        RemoteLearner([endpoint]) as learner,
        RemoteLearner([endpoint]) as other,
        closing(sqlite3.connect(path, isolation_level=None)) as plain,
    ):
        learner.record(recording_of(0.03))
        plain.execute("BEGIN IMMEDIATE")
        recorded: list[Any] = []
        writing = threading.Thread(target=lambda: recorded.append(other.record(recording_of(0.04))))
        writing.start()
        assert learner.query("squat", robot=ROBOT, amplitude=0.03).kind == "learned"
        assert [entry.entry for entry in learner.entries()] == [1]
        assert writing.is_alive()
        plain.execute("ROLLBACK")
        writing.join()
        assert [entry.entry for entry in learner.entries()] == [1, 2]
        assert len(recorded) == 1
        # what was asked before is looked up anew once somebody has written
        assert learner.query("squat", robot=ROBOT, amplitude=0.03).iteration == 1
        applied = learner.query("squat", robot=ROBOT, amplitude=0.03).weights
        learner.record(replace(recording_of(0.03, 0.005), applied=applied))
        assert learner.query("squat", robot=ROBOT, amplitude=0.03).iteration == 2


def test_a_long_list_comes_page_by_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, endpoint = tmp_path / "a.sqlite", free_endpoint()
    fill(path, 7)
    with (
        ServiceProcess(["learner", "--database", str(path), "--listen", endpoint]),
        RemoteLearner([endpoint]) as learner,
    ):
        newest = learner.database(limit=2)
        assert ([each.entry for each in newest.entries], newest.more) == ([6, 7], 5)
        assert learner.database("other").entries == []
        monkeypatch.setattr("tsd_clients.remote.remote_learner.LARGEST_PAGE", 3)
        assert [len(page.entries) for page in learner.pages()] == [3, 3, 1]
        assert [each.entry for each in learner.entries(ROBOT, "squat")] == list(range(1, 8))
        assert learner.entries(motion="sway") == []
        # what the list says of all is what it says page by page
        command = [sys.executable, "-m", "tsd_cli", "database", "list", "--connect", endpoint]
        listed = subprocess.run([*command, "--json", "-"], capture_output=True, check=True)
        reply = DatabaseReply.decode(listed.stdout)
        assert reply.entries == learner.entries()
        shown = subprocess.run([*command, "--limit", "2"], capture_output=True, check=True)
        assert b"5 more" in shown.stdout


def test_a_full_disk_is_named_and_queries_go_on(tmp_path: Path) -> None:
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(tmp_path)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True).returncode != 0:
        pytest.skip("a small disk needs root")
    path, endpoint = tmp_path / "a.sqlite", free_endpoint()
    try:
        with (
            ServiceProcess(["learner", "--database", str(path), "--listen", endpoint]),
            RemoteLearner([endpoint]) as learner,
        ):
            answered = 0
            with pytest.raises(DatabaseError, match=r"a\.sqlite.*full.*free disk space"):
                for number in range(1000):
                    learner.record(recording_of(0.02 + number / 1e4))
                    answered += 1
            assert len(learner.entries()) == answered > 5
            assert learner.query("squat", robot=ROBOT, amplitude=0.02).kind == "learned"
            with pytest.raises(DatabaseError, match="full"):
                learner.record(recording_of(0.5))
    finally:
        subprocess.run(["umount", "-l", str(tmp_path)], check=True)


def test_file_that_is_not_ours_is_refused_unchanged(tmp_path: Path) -> None:
    other = tmp_path / "thesis.txt"
    other.write_text("not a database" * 100)
    with pytest.raises(ServiceNotReady, match=r"not a database of this project.*not changed"):
        ServiceProcess(["learner", "--database", str(other), "--listen", free_endpoint()])
    assert other.read_text() == "not a database" * 100


def test_signal_ends_the_service_cleanly(tmp_path: Path) -> None:
    arguments = ["learner", "--database", str(tmp_path / "a.sqlite"), "--listen", free_endpoint()]
    with ServiceProcess(arguments) as service:
        start = time.monotonic()
        service.process.send_signal(signal.SIGINT)
        assert service.process.wait(timeout=5.0) == 0
        assert time.monotonic() - start < 2.0


def test_nobody_there() -> None:
    with pytest.raises(ServiceUnreachable, match="start one with 'tsd learner'"):
        RemoteLearner([free_endpoint()])


def test_client_refuses_two_learners(endpoint: str, tmp_path: Path) -> None:
    other = free_endpoint()
    arguments = ["learner", "--database", str(tmp_path / "b.sqlite"), "--listen", other]
    with ServiceProcess(arguments), RemoteLearner([endpoint, other]) as learner:
        deadline = time.monotonic() + 10.0
        with pytest.raises(TwoServices, match="2 learners"):
            while time.monotonic() < deadline:  # the second link may come up later
                learner.database()
