from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tsd_casadi.exceptions import AlreadyRunning, RunDirectoryUnusable
from tsd_casadi.wire.registration import Registration
from tsd_casadi.wire.run_directory import is_stopped, run_directory, running
from tsd_casadi.wire.run_record import RunRecord


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "run"
    monkeypatch.setenv("TSD_RUN_DIR", str(path))
    return path


def record(role: str = "controller", subject: str = "robot") -> RunRecord:
    return RunRecord.of_this_process(
        role, subject, robot="robot", endpoints=("tcp/127.0.0.1:7447",), instance=5
    )


def test_the_folder_is_made_for_its_owner_alone(folder: Path) -> None:
    assert run_directory() == folder
    assert folder.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("mode", [0o701, 0o710, 0o750, 0o755, 0o777])
def test_a_folder_that_others_can_enter_is_refused(folder: Path, mode: int) -> None:
    folder.mkdir()
    folder.chmod(mode)
    with pytest.raises(RunDirectoryUnusable, match="others can enter it") as caught:
        run_directory()
    assert caught.value.path == folder


def test_what_is_no_folder_is_refused(folder: Path, tmp_path: Path) -> None:
    folder.write_text("")
    with pytest.raises(RunDirectoryUnusable, match="no folder"):
        run_directory()
    folder.unlink()
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    folder.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(RunDirectoryUnusable, match="no folder"):
        run_directory()


def test_a_folder_that_cannot_be_made_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("TSD_RUN_DIR", str(tmp_path / "file" / "run"))
    with pytest.raises(RunDirectoryUnusable, match=r"Not a directory|File exists"):
        run_directory()


def test_the_folder_of_another_user_is_refused(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_directory()
    monkeypatch.setattr("os.geteuid", lambda: os.getuid() + 1)
    with pytest.raises(RunDirectoryUnusable, match="another user"):
        run_directory()


@pytest.mark.parametrize(
    ("runtime", "expected"), [("run", "run/tsd"), ("", "cache/tsd_casadi/run")]
)
def test_where_the_folder_is(
    runtime: str, expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("TSD_RUN_DIR")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / runtime) if runtime else "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert run_directory() == tmp_path / expected


def test_what_runs_is_listed_until_it_closes(folder: Path) -> None:
    assert running() == []
    first, second = record(), record("learner", "a.sqlite")
    with Registration(first):
        with Registration(second):
            assert running() == [first, second]
        assert running() == [first]
    assert list(folder.iterdir()) == []


def test_a_second_one_is_refused_and_the_first_named() -> None:
    with Registration(first := record()):
        with pytest.raises(AlreadyRunning, match="controller for robot") as caught:
            Registration(record())
        assert caught.value.pid == os.getpid()
        assert caught.value.endpoint == "tcp/127.0.0.1:7447"
        assert caught.value.since == first.started
        Registration(record("learner")).close()
        Registration(record(subject="another robot")).close()
    Registration(record()).close()


def test_one_that_was_killed_leaves_nothing(folder: Path) -> None:
    program = (
        "import os, signal; from tsd_casadi.wire.registration import *;"
        "Registration(RunRecord.of_this_process('controller', 'robot', robot='robot',"
        "endpoints=('tcp/127.0.0.1:1',), instance=1)); os.kill(os.getpid(), signal.SIGKILL)"
    )
    subprocess.run([sys.executable, "-c", program], check=False)
    assert len(list(folder.iterdir())) == 1
    assert running() == []
    assert list(folder.iterdir()) == []


def test_the_place_of_one_that_was_killed_is_free(folder: Path) -> None:
    with Registration(record()):
        (name,) = folder.iterdir()
    name.write_text("what a process wrote that is gone by now, longer than a record " * 20)
    with Registration(record()):
        (found,) = running()
        assert found.pid == os.getpid()


def test_what_is_no_record_is_not_listed(folder: Path) -> None:
    with Registration(record()):
        (path,) = folder.iterdir()
        path.write_text("{")
        assert running() == []
        with pytest.raises(AlreadyRunning, match="it is starting"):
            Registration(record())


def test_this_process_is_not_stopped() -> None:
    assert not is_stopped(os.getpid())
    assert not is_stopped(2**30)
