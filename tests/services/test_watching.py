"""A run is watched from other processes, and nobody who watches touches it."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
import zenoh

import tsd_casadi as tsd
from tsd_casadi.database.database import Database
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.exceptions import EntryNotFound
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.repetition.learn import learn
from tsd_casadi.state import Matrix
from tsd_casadi.wire.keys import rows_key, story_key
from tsd_casadi.wire.run_record import RunRecord
from tsd_casadi.wire.session_settings import session_settings
from tsd_casadi.wire.telemetry import (
    LapDone,
    RepetitionBegan,
    RepetitionEnded,
    RunOver,
    RunStory,
)
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_clients.telemetry.feed import Feed
from tsd_clients.telemetry.telemetry import Telemetry
from tsd_clients.telemetry.telling_learner import TellingLearner
from tsd_clients.telemetry.watched_run import WatchedRun, watched_runs

MOTION = Squat(0.02, 1.0)


@pytest.fixture(autouse=True)
def own_run_directory(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("TSD_RUN_DIR", str(tmp_path / "run"))


@pytest.fixture(scope="module")
def simulator(robot: tsd.Robot) -> MujocoSimulator:
    return MujocoSimulator(robot, 0.1)


def take_until(run: WatchedRun, done: Callable[[], bool]) -> Matrix:
    """Take rows until something is true, however long that takes; the test's time bounds it."""
    rows = [run.take()]
    while not done():
        rows.append(run.take())
        time.sleep(0.002)  # leaves the core to the others
    return np.concatenate([each for each in rows if len(each)] or rows[:1])


class Watching:
    """Watches in this process, from before the first tick on."""

    def start(self, setting: Setting) -> None:
        (record,) = watched_runs()
        self.record, self.run, self.rows = record, WatchedRun(record), []
        take_until(self.run, lambda: self.run.outline is not None)

    def tick(self, moment: Moment) -> None:
        pass

    missed = tick

    def lap(self, lap: Lap) -> None:
        self.rows.append(self.run.take())

    def end(self, outcome: str) -> None:
        self.rows.append(self.run.take())


@contextmanager
def stranger(record: RunRecord, mode: str = "client") -> Iterator[zenoh.Session]:
    settings = session_settings(connect=record.endpoints)
    settings["mode"] = mode
    session = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
    try:
        yield session
    finally:
        session.close()  # type: ignore[no-untyped-call]


def connection(record: RunRecord) -> socket.socket:
    host, _, port = record.endpoints[0].partition("/")[2].rpartition(":")
    return socket.create_connection((host, int(port)))


@contextmanager
def fed(robot: str = "robot", instance: int = 7) -> Iterator[tuple[Feed, RunRecord]]:
    """A publishing process, and the run's end of its pipe."""
    process = subprocess.Popen(
        [sys.executable, "-m", "tsd_clients.telemetry.publisher", robot, str(instance)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    feed = Feed(os.dup(process.stdin.fileno()))
    process.stdin.close()
    endpoint = process.stdout.readline().decode().strip()
    record = RunRecord.of_this_process(
        "run", "one", robot=robot, endpoints=(endpoint,), instance=instance, motion="squat"
    )
    try:
        yield feed, record
    finally:
        feed.close(0.0)
        process.wait()
        process.stdout.close()


def test_who_watches_sees_every_tick_counted_and_what_came_of_it(
    simulator: MujocoSimulator, controller: tsd.Controller
) -> None:
    watching = Watching()
    with Telemetry(controller.format.robot, {"model_error": 0.1}) as telemetry:
        done = simulator.run(controller, MOTION, laps=2, observers=[telemetry, watching])
        telemetry.measured(done, ["a note"])
        run = watching.run
        watching.rows.append(take_until(run, lambda: run.measured is not None))
        # somebody who comes late is told the same
        with WatchedRun(watching.record) as late:
            take_until(late, lambda: late.measured is not None)
            assert late.events == run.events
    assert telemetry.dropped == 0
    assert telemetry.trouble == ""
    take_until(run, lambda: run.ended)
    assert (run.reason, run.lost, run.trouble, run.dropped) == ("", False, "", 0)
    assert watched_runs() == []
    run.close()
    assert run.outline is not None
    assert run.layout is not None
    assert run.measured is not None
    rows, layout = np.concatenate([each for each in watching.rows if len(each)]), run.layout
    ticks = rows[:, layout.slice("ticks")][:, 0].astype(int)
    last = np.cumsum(ticks) - 1
    np.testing.assert_array_equal(rows[:, layout.slice("time")][:, 0], done.log["time"][last])
    q = rows[:, layout.slice("true_q")]
    assert q == pytest.approx(done.log["q"][last], abs=1e-6)
    assert run.outline.axes == done.axes
    assert run.outcome == "steady"
    assert run.measured.summary == json.loads(json.dumps(done.summary()))
    assert run.measured.notes == ["a note"]
    assert len(run.laps) == done.laps_run
    for axis in done.learned:
        error = done.log["error"][done.log["lap"] == 0][:, done.axes.index(axis)]
        assert run.laps[0].rms[axis] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-6)


def test_iterations_are_told_with_weights_before_and_after(
    simulator: MujocoSimulator, controller: tsd.Controller, robot: tsd.Robot, tmp_path: Path
) -> None:
    with (
        Database(tmp_path / "a.sqlite") as database,
        Telemetry(robot.name) as telemetry,
    ):
        learner = TellingLearner(database, telemetry)
        runs = learn(
            simulator,
            controller,
            [MOTION],
            learner,
            iterations=1,
            laps=2,
            observers=[telemetry],
        )
        (record,) = watched_runs()
        with WatchedRun(record) as run:
            take_until(run, lambda: len(run.iterations) == 2)
            first, second = run.iterations
        served = database.query(
            "squat", robot=robot.name, kind="learned", axes=runs[0].learned, **MOTION.parameters
        )
    assert (first.iteration, second.iteration) == (0, 1)
    assert (first.repetition, second.repetition) == (1, 2)
    assert second.learned_from == 0
    assert not np.any(first.before)
    np.testing.assert_array_equal(np.array(first.after), served.weights)
    np.testing.assert_array_equal(second.before, first.after)
    for told, done in zip((first, second), runs, strict=True):
        assert told.rank == done.rank
        assert told.errors["com.z"].rms == done.errors["com.z"].rms
        assert told.errors["com.z"].deviation is not None


def test_a_learner_that_knows_nothing_says_so_through_the_one_before_it(
    robot: tsd.Robot, tmp_path: Path
) -> None:
    with Database(tmp_path / "a.sqlite") as database, Telemetry(robot.name) as telemetry:
        learner = TellingLearner(database, telemetry)
        with pytest.raises(EntryNotFound):
            learner.query("squat", robot=robot.name, kind="learned", **MOTION.parameters)


def test_somebody_who_never_reads_is_dropped_from_and_nobody_waits() -> None:
    payload = bytes(100_000)
    with fed() as (feed, record):
        asleep = subprocess.Popen(
            [sys.executable, "-c", SUBSCRIBE, record.endpoints[0]], stdout=subprocess.PIPE
        )
        try:
            assert asleep.stdout is not None
            assert asleep.stdout.readline() == b"subscribed\n"
            asleep.send_signal(signal.SIGSTOP)
            os.waitid(os.P_PID, asleep.pid, os.WSTOPPED)
            silent = [connection(record) for _ in range(100)]
            # 60 MB, far more than all buffers on the way
            sent = 0
            while sent < 600:
                sent += feed.send_rows(payload)
                os.sched_yield()
            feed.send_event(RepetitionEnded(number=1, repetition=1, outcome="steady").encode())
            with WatchedRun(record) as run:
                take_until(run, lambda: len(run.events) == 1)
                assert not run.lost
            for each in silent:
                each.close()
        finally:
            asleep.kill()
            asleep.wait()
            assert asleep.stdout is not None
            asleep.stdout.close()


SUBSCRIBE = """
import json, sys, zenoh
from tsd_casadi.wire.session_settings import session_settings
settings = session_settings(connect=[sys.argv[1]])
session = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
part = session.declare_subscriber("**", zenoh.handlers.FifoChannel(1))
list(session.get("tsd/*/run/*/story"))  # the subscription has arrived with it
print("subscribed", flush=True)
part.recv()
sys.stdin.read()
"""


def test_a_run_without_an_end_is_said_to_be_over() -> None:
    with fed() as (feed, record), WatchedRun(record) as run:
        feed.send_event(RepetitionEnded(number=1, repetition=3, outcome="steady").encode())
        take_until(run, lambda: run.outcome == "steady")
        feed.close(1.0)
        take_until(run, lambda: run.ended)
    assert run.reason == "its process ended in the middle of it"
    assert isinstance(run.events[-1], RunOver)


def test_a_run_of_the_command_line_is_listed_watched_and_missed_when_it_is_killed(
    controller: tsd.Controller,
) -> None:
    command = [sys.executable, "-m", "tsd_cli"]
    options = [
        "simulate",
        "squat",
        "--controller",
        "local",
        "--laps",
        "1000",
        "--model-error",
        "0.1",
    ]
    process = subprocess.Popen([*command, *options], stderr=subprocess.DEVNULL)
    try:
        while not (records := watched_runs()):
            assert process.poll() is None
            time.sleep(0.01)
        with WatchedRun(records[0]) as run:
            take_until(run, lambda: len(run.laps) == 1)
            shown = subprocess.run(
                [*command, "status", "--json", "-"], capture_output=True, check=True
            )
            process.kill()
            take_until(run, lambda: run.ended)
    finally:
        process.kill()
        process.wait()
    (told,) = json.loads(shown.stdout)["runs"]
    assert told["motion"] == "squat"
    assert told["robot"] == controller.format.robot
    assert told["pid"] == process.pid
    assert told["telemetry"] == records[0].telemetry
    began = run.events[0]
    assert isinstance(began, RepetitionBegan)
    assert began.settings["model_error"] == 0.1
    assert run.reason == "its process ended in the middle of it"
    assert watched_runs() == []


def test_a_run_whose_publisher_was_killed_is_lost(controller: tsd.Controller) -> None:
    with Telemetry("robot") as telemetry:
        telemetry._sign_on("squat")
        (record,) = watched_runs()
        with WatchedRun(record) as run:
            take_until(run, lambda: run._link.is_there)
            assert not run.lost
            telemetry._process.kill()
            take_until(run, lambda: run.lost)
    assert not run.ended


@pytest.mark.parametrize("mode", ["client", "peer", "router"])
def test_strangers_are_not_heard(mode: str) -> None:
    nothing = {"com.z": 0.0}
    foreign = RunStory(events=[RepetitionEnded(number=9, repetition=9, outcome="fell")]).encode()

    def answer(query: zenoh.Query) -> None:
        with query:
            query.reply(story_key("robot", 7), foreign)

    with fed() as (feed, record), stranger(record, mode) as session:
        part = session.declare_queryable(
            "**", zenoh.handlers.Callback(answer, indirect=False), complete=True
        )
        with WatchedRun(record) as run:
            for number in range(1, 21):
                session.put(rows_key("robot", 7), b"foreign")
                session.put("tsd/robot/run/7/events", foreign)
                feed.send_event(
                    LapDone(
                        number=number,
                        repetition=1,
                        lap=number,
                        rms=nothing,
                        ac_rms=nothing,
                        mean_abs_feedback=nothing,
                    ).encode()
                )
                take_until(run, lambda number=number: len(run.laps) == number)  # type: ignore[misc]
            assert run.trouble == ""
            assert {event.event for event in run.events} == {"lap"}
        del part


def test_a_port_that_is_taken_or_a_folder_that_cannot_be_used_is_told(
    simulator: MujocoSimulator,
    controller: tsd.Controller,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / "open").mkdir(mode=0o777)
    (tmp_path / "open").chmod(0o777)
    monkeypatch.setenv("TSD_RUN_DIR", str(tmp_path / "open"))
    with Telemetry(controller.format.robot) as telemetry:
        run = simulator.run(controller, MOTION, laps=2, observers=[telemetry])
    assert run.steady
    assert "others can enter it" in telemetry.trouble
    with suppress(FileNotFoundError):
        (tmp_path / "open").rmdir()
