"""A simulated run as MCAP: read by others, and what becomes of it when something dies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tsd_casadi.controller.controller import Controller
from tsd_casadi.exceptions.logs import LogNotWritten
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.compensator import Compensator, Moment
from tsd_casadi.repetition.run import Run
from tsd_casadi.state import State
from tsd_clients.logs import write_mcap
from tsd_clients.logs.log import Log
from tsd_clients.logs.mcap_log import McapLog
from tsd_clients.logs.read_log import read_log
from tsd_clients.logs.run_summary import KILLED
from tsd_clients.logs.unblocked_pipe import FRAME
from tsd_clients.simulator.simulator import MujocoSimulator


class Dropping(Compensator):
    """Drops the feedforward in the second lap, as a gate does."""

    def before(self, moment: Moment) -> None:
        if moment.lap == 1:
            self.veto = "it harms"


@pytest.fixture(scope="module")
def logged(
    simulator: MujocoSimulator, controller: Controller, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Run, Path]:
    path = tmp_path_factory.mktemp("logs") / "run.mcap"
    dropping = Dropping()
    log = McapLog(path, [dropping], {"seed": 0})
    run = simulator.run(
        controller, Squat(0.02, 1.0), laps=2, observers=[log], compensators=[dropping]
    )
    log.conclude(run)
    return run, path


@pytest.fixture(scope="module")
def found(logged: tuple[Run, Path]) -> dict[str, list[Any]]:
    """Time and content of every message, by the readers of mcap, checksums checked."""
    found: dict[str, list[Any]] = {}
    with logged[1].open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    return found


def test_the_log_is_that_of_the_run(logged: tuple[Run, Path]) -> None:
    run, path = logged
    log: Log = read_log(path)
    assert log.fields.keys() == run.log.keys()
    for name, values in run.log.items():
        np.testing.assert_array_equal(log.fields[name], values, err_msg=name)
        assert log.fields[name].dtype == values.dtype
    assert (log.axes, log.robot, log.model) == (run.axes, run.robot, run.model)
    assert log.summary["errors"] == run.summary()["errors"]
    assert log.outline is not None and log.outline.motion == "squat"
    for axis, error in run.errors.items():
        assert log.errors[axis].rms == pytest.approx(error.rms, abs=1e-9)


def test_measures_from_what_others_read(
    logged: tuple[Run, Path], found: dict[str, list[Any]]
) -> None:
    run, _ = logged
    ticks = [tick for _, tick in found["/tsd/tick"]]
    assert len(ticks) == run.ticks == len(found["/joint_states"])
    lap = np.array([tick.lap for tick in ticks])
    error = np.array([tick.error for tick in ticks])[run.log["measured"], 0]
    assert np.sqrt(np.mean(error**2)) == pytest.approx(run.errors["com.z"].rms, abs=1e-9)
    np.testing.assert_array_equal(lap, run.log["lap"])
    times = np.array([time for time, _ in found["/tsd/tick"]])
    np.testing.assert_allclose(1e-9 * (times - times[0]), run.log["time"], atol=1e-9)


def test_rosbags_reads_all_of_it(logged: tuple[Run, Path]) -> None:
    run, path = logged
    store = get_typestore(Stores.EMPTY)
    counts: dict[str, int] = {}
    with Reader(path) as reader:
        for each in reader.connections:
            if each.msgtype not in store.types:
                store.register(get_types_from_msg(each.msgdef.data, each.msgtype))
        for each, _, raw in reader.messages():
            store.deserialize_cdr(raw, each.msgtype)
            counts[each.topic] = counts.get(each.topic, 0) + 1
    assert counts["/tsd/tick"] == counts["/contacts/left_foot/wrench"] == run.ticks
    assert counts["/robot_description"] == 1
    assert counts["/tf"] == pytest.approx(run.ticks / 20, abs=2)


def test_links_are_where_mujoco_has_them(
    logged: tuple[Run, Path], found: dict[str, list[Any]], simulator: MujocoSimulator
) -> None:
    run, _ = logged
    began = found["/tsd/tick"][0][0]
    model, data = simulator.model, mujoco.MjData(simulator.model)
    compared = 0
    for time, message in found["/tf"][:: len(found["/tf"]) // 5]:
        tick = round(1e-9 * (time - began) / 1e-3)
        q, v = (run.log[name][tick].astype(float) for name in ("q", "v"))
        simulator.state_map.write(data, State(q, v))
        mujoco.mj_kinematics(model, data)
        for each in message.transforms:
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, each.child_frame_id)
            if body >= 0:
                place = each.transform.translation
                np.testing.assert_allclose(
                    (place.x, place.y, place.z), data.xpos[body], atol=2e-6
                )  # q is kept in 32 bits
                compared += 1
    assert compared > 50


def test_diagnostics_tell_laps_and_vetoes(found: dict[str, list[Any]]) -> None:
    told = [{each.name: each for each in array.status} for _, array in found["/diagnostics"]]
    laps = [each["tsd: lap"].message for each in told]
    assert list(dict.fromkeys(laps))[:3] == ["holding", "lap 0", "lap 1"]
    feedforward = [each["tsd: feedforward"] for each in told]
    assert feedforward[0].level == 0
    assert (feedforward[-1].level, feedforward[-1].message) == (1, "it harms")


class Deadly:
    """Kills the writer of a log in the middle of a run."""

    def __init__(self, log: McapLog, ticks: int) -> None:
        self.log, self.left = log, ticks

    def start(self, setting: object) -> None: ...
    def missed(self, moment: object) -> None: ...
    def lap(self, lap: object) -> None: ...
    def end(self, outcome: str) -> None: ...

    def tick(self, moment: object) -> None:
        self.left -= 1
        if self.left == 0:
            os.kill(self.log.writer, signal.SIGKILL)


def test_a_writer_that_dies_does_not_stop_the_run(
    simulator: MujocoSimulator, controller: Controller, tmp_path: Path
) -> None:
    log = McapLog(tmp_path / "run.mcap")
    run = simulator.run(controller, Squat(0.02, 1.0), laps=2, observers=[log, Deadly(log, 500)])
    assert run.steady and run.ticks > 2000
    with pytest.raises(LogNotWritten, match=r"run\.mcap.*killed by signal 9"):
        log.conclude(run)


@pytest.mark.parametrize("place", ["nowhere/run.mcap", "full.mcap"])
def test_what_cannot_be_begun_is_told_before_the_first_tick(
    simulator: MujocoSimulator, controller: Controller, tmp_path: Path, place: str
) -> None:
    (tmp_path / "full.mcap").symlink_to("/dev/full")
    log = McapLog(tmp_path / place)
    with pytest.raises(LogNotWritten, match=r"No such file|No space left"):
        simulator.run(controller, Squat(0.02, 1.0), laps=2, observers=[log])


def test_what_is_interrupted_is_whole_and_says_so(
    simulator: MujocoSimulator, controller: Controller, tmp_path: Path
) -> None:
    path, kept = tmp_path / "run.mcap", list[Run]()
    log = McapLog(path)

    def interrupt(done: float, total: float) -> None:
        if done > 1.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulator.run(
            controller,
            Squat(0.02, 1.0),
            observers=[log],
            progress=interrupt,
            on_abort=kept.append,
        )
    log.conclude(kept[0])
    found = read_log(path)
    assert found.summary["aborted"] == "KeyboardInterrupt"
    assert found.ticks == kept[0].ticks


def test_a_run_that_is_killed_leaves_a_whole_file(logged: tuple[Run, Path], tmp_path: Path) -> None:
    """Its writer outlives it and has every row that was handed over."""
    log = read_log(logged[1])
    assert log.outline is not None
    rows = np.zeros((400, log.outline.layout.size))
    rows[:, 0] = 1e-3 * np.arange(400)
    for name in ("q", "true_q"):
        rows[:, log.outline.layout.slice(name)] = log.fields["q"][0]
    content = [(write_mcap.OUTLINE, write_mcap.BEGAN.pack(0) + log.outline.encode())]
    content += [(write_mcap.ROW, row.tobytes()) for row in rows]
    sent = b"".join(FRAME.pack(kind, len(each)) + each for kind, each in content)
    path = tmp_path / "run.mcap"
    writer = subprocess.run(
        [sys.executable, "-m", write_mcap.__name__, str(path)],
        input=sent + b"half a frame",
        capture_output=True,
    )
    assert (writer.returncode, writer.stderr) == (0, b"")
    found = read_log(path)
    assert found.ticks == 400 and found.summary == {"aborted": KILLED}
