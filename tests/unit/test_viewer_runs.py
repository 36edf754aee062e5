"""What the page shows of a run, live and from a log, without a browser."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.robot.robot import Robot
from tsd_casadi.tick.row_state import RowState
from tsd_casadi.wire.run_record import RunRecord
from tsd_clients.logs.log import Log
from tsd_clients.viewer import service_watch
from tsd_clients.viewer.panels.joint_panel import joints_table, limits_table
from tsd_clients.viewer.panels.run_panel import _distinct
from tsd_clients.viewer.panels.service_panel import duration
from tsd_clients.viewer.replay import WINDOW, Replay
from tsd_clients.viewer.rolling import Rolling
from tsd_clients.viewer.service_watch import ServiceWatch
from tsd_clients.viewer.ticks import ticks_of_log

TICKS = 3000
PERIOD = 0.01


def make_log(robot: Robot) -> Log:
    sizes = {
        "(k,)": 2,
        "(a,)": sum(len(task.axes) for task in robot.description.all_tasks),
        "(7 + n,)": robot.nq,
        "(6 + n,)": robot.nv,
        "(n,)": robot.n,
        "(6 c,)": 6 * len(robot.feet),
    }
    fields = {
        name: np.zeros(TICKS if field.shape == "()" else (TICKS, sizes[field.shape]), field.type)
        for name, field in LOG_FIELDS.items()
    }
    fields["time"] = PERIOD * np.arange(TICKS)
    fields["q"] += robot.home.q.astype(np.float32)
    fields["q"][:, 7] = np.sin(fields["time"])
    fields["tau"][:] = 0.5 * robot.torque_limit
    return Log(fields, ("com.z", "com.x"), robot=robot.name)


@pytest.fixture(scope="module")
def replay(robot: Robot) -> Replay:
    return Replay(Path("run.npz"), make_log(robot), robot)


@given(st.lists(st.integers(0, 25), max_size=20))
def test_rolling_keeps_the_newest_in_order(sizes: list[int]) -> None:
    rolling, came = Rolling(10, 2), np.empty((0, 2))
    for size in sizes:
        rows = np.arange(len(came), len(came) + size)[:, None] * np.ones(2)
        rolling.add(rows)
        came = np.vstack((came, rows))
        assert np.array_equal(rolling.rows, came[-10:])


def test_a_replay_shows_the_seconds_before_its_moment(replay: Replay) -> None:
    replay.move_to(20.0)
    ticks = replay.ticks
    assert ticks.time[-1] == pytest.approx(20.0)
    assert ticks.time[0] == pytest.approx(20.0 - WINDOW, abs=PERIOD)
    assert ticks.q[-1, 7] == pytest.approx(np.sin(20.0), abs=1e-6)
    replay.move_to(-1.0)
    assert len(replay.ticks) == 1
    replay.move_to(1e9)
    assert replay.time == pytest.approx(replay.end)


def test_a_replay_goes_by_the_clock_while_it_plays(replay: Replay) -> None:
    replay.move_to(1.0)
    replay.playing, replay.speed = True, 2.0
    replay.poll(100.0)
    replay.move_to(1.0)
    replay.poll(101.5)
    assert replay.time == pytest.approx(4.0)
    replay.playing = False
    replay.poll(200.0)
    assert replay.time == pytest.approx(4.0)
    replay.playing = True
    replay.move_to(replay.end)
    replay.poll(201.0)
    assert replay.time == replay.begin


def test_a_log_of_another_robot_is_refused(robot: Robot, mini_biped: Robot) -> None:
    with pytest.raises(InvalidValue, match="--robot"):
        Replay(Path("run.npz"), make_log(robot), mini_biped)


def test_joints_are_written_with_angle_torque_and_share(replay: Replay, robot: Robot) -> None:
    replay.move_to(1.0)
    table = joints_table(replay.label, replay.ticks)
    joint = robot.joint_names[0]
    assert f"data-angle='{joint}'" in table
    assert f">{np.sin(1.0):.3f}<" in table
    assert table.count("width:50.0%") == robot.n


def test_limits_are_named_by_what_binds_and_how_often(robot: Robot) -> None:
    log = make_log(robot)
    log.fields["joint_limits"][TICKS // 2 :, 3] = -RowState.AT_POSITION
    ticks = ticks_of_log(log)
    label = Replay(Path("run.npz"), log, robot).label
    assert "None in the last seconds" in limits_table(label, ticks.part(0, 10))
    table = limits_table(label, ticks)
    assert f"joint_position.{robot.joint_names[3]}" in table
    assert "50 %" in table and ">now<" in table


def test_same_titles_are_told_apart() -> None:
    assert _distinct(["a", "b", "a"]) == ["a #1", "b", "a #2"]


@pytest.mark.parametrize(
    ("seconds", "said"), [(3, "3 s"), (61, "1 min"), (5400, "1.5 h"), (2 * 86400, "2.0 d")]
)
def test_durations(seconds: float, said: str) -> None:
    assert duration(seconds) == said


def test_a_service_that_is_gone_is_lost_until_it_is_back(monkeypatch: pytest.MonkeyPatch) -> None:
    def record(pid: int) -> RunRecord:
        return RunRecord(
            role="controller",
            subject="robot",
            robot="robot",
            pid=pid,
            endpoints=("tls/127.0.0.1:1",),
            instance=pid,
            started="2026-01-01T00:00:00+00:00",
        )

    here = [record(11)]
    monkeypatch.setattr(service_watch, "running", lambda: list(here))
    watch = ServiceWatch()
    try:
        now = time.monotonic()
        watch.poll(now)
        assert [service.lost for service in watch.services] == [None]
        here.clear()
        watch.poll(now + service_watch.LOOK / 2)
        assert [service.lost for service in watch.services] == [None]
        watch.poll(now + 2 * service_watch.LOOK)
        assert [service.lost for service in watch.services] == [now + 2 * service_watch.LOOK]
        here.append(record(12))
        watch.poll(now + 4 * service_watch.LOOK)
        assert [(s.record.pid, s.lost) for s in watch.services] == [(12, None)]
    finally:
        watch.close()
