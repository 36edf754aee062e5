from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.whole_file import check_writable, write_whole


def test_a_file_is_there_when_all_is_written(tmp_path: Path) -> None:
    path = tmp_path / "new.json"
    with write_whole(path) as file:
        file.write(b"half")
        file.flush()
        assert not path.exists()
        file.write(b" and half")
    assert path.read_bytes() == b"half and half"
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_what_ends_early_leaves_what_was_there(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "kept.json"
    path.write_text("before")

    def fail() -> None:
        with write_whole(path) as file:
            file.write(b"after")
            raise error

    with pytest.raises(error):
        fail()
    assert path.read_text() == "before"
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


def test_permissions_stay_those_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "shared.json"
    path.touch(mode=0o640)
    path.chmod(0o640)
    with write_whole(path) as file:
        file.write(b"x")
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "named")
    with write_whole(tmp_path / "link") as file:
        file.write(b"x")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "named").read_bytes() == b"x"


def test_a_pipe_is_written_to_and_stays_one(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        check_writable(pipe)
        with write_whole(pipe) as file:
            file.write(b"through")
        assert os.read(reader, 100) == b"through"
    finally:
        os.close(reader)
    assert pipe.is_fifo()


def test_checking_leaves_no_trace(tmp_path: Path) -> None:
    check_writable(tmp_path / "new.json")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("place", "reason"),
    [("", "is a folder"), ("nowhere/x.json", "there is no folder"), ("file/x", "no folder")],
)
def test_what_cannot_be_written_is_refused_before_and_after(
    tmp_path: Path, place: str, reason: str
) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InvalidValue, match=f"output file is .*{reason}.*writable path"):
        check_writable(tmp_path / place)
    with pytest.raises(InvalidValue, match="output file"), write_whole(tmp_path / place) as file:
        file.write(b"x")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_without_permission_it_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(InvalidValue, match="the folder cannot be written to"):
        check_writable(tmp_path / "x.json")
