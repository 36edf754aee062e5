"""docs/own-motion.md does what it says: its file, its commands, its program, its table."""

from __future__ import annotations

import math
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import tsd_casadi as tsd
from tsd_server.service_process import ServiceProcess, free_endpoint

PAGE = (Path(__file__).parents[2] / "docs" / "own-motion.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture(scope="module")
def connect(
    controller: tsd.Controller, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[list[str]]:
    endpoints = free_endpoint(), free_endpoint()
    database = str(tmp_path_factory.mktemp("own") / "own.sqlite")
    with (
        ServiceProcess(["controller", "--listen", endpoints[0]]),
        ServiceProcess(["learner", "--database", database, "--listen", endpoints[1]]),
    ):
        yield ["--connect", endpoints[0], "--connect", endpoints[1]]


def done_in(folder: Path, *command: str) -> str:
    done = subprocess.run(
        [sys.executable, *command],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env={**os.environ, "COLUMNS": "120"},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def errors_of(table: str, axis: str) -> list[float]:
    """RMS errors of an axis in a table of runs [mm]."""
    return [float(value) for value in re.findall(rf"{axis} +([0-9.]+)", table)]


def test_the_class_and_its_commands(connect: list[str], tmp_path: Path) -> None:
    (tmp_path / "my_motion.py").write_text(blocks("python")[0])
    shown, none, learned, answer, after = (
        done_in(tmp_path, "-m", "tsd_cli", *words[1:], *([] if "show" in words else connect))
        for words in map(shlex.split, blocks("sh")[0].splitlines())
    )
    assert "moves com.y, com.z; learns com.y, com.z, com.x" in " ".join(shown.split())
    assert "learned feedforward along com.y, com.z, com.x for frequency 0.5 Hz" in " ".join(
        answer.split()
    )
    for axis in ("com.y", "com.z"):
        first, _, third = errors_of(learned, axis)
        assert errors_of(none, axis) == [first]
        (again,) = errors_of(after, axis)
        assert first > 30 * third
        assert again == pytest.approx(third, rel=0.5)


def test_the_program_without_services(controller: tsd.Controller, tmp_path: Path) -> None:
    (tmp_path / "my_motion.py").write_text(blocks("python")[0])
    (tmp_path / "roll.py").write_text(blocks("python")[1])
    first, _, third = done_in(tmp_path, "roll.py").splitlines()
    assert "roll radius=0.02 frequency=0.5" in first
    assert errors_of(first, "com.z")[0] > 30 * errors_of(third, "com.z")[0]


def test_the_file_of_references(controller: tsd.Controller, tmp_path: Path) -> None:
    header, *_ = blocks("text")[0].splitlines()
    rows = [
        f"{0.05 * i:.2f},{0.02 * math.sin(a):.4f},{0.01 * (math.cos(a) - 1):.4f}"
        for i, a in ((i, 2 * math.pi * i / 80) for i in range(81))
    ]
    assert rows[1].startswith("0.05,0.0016")
    (tmp_path / "wave.csv").write_text("\n".join([header, *rows]) + "\n")
    (words, _) = map(shlex.split, blocks("sh")[1].splitlines())
    table = done_in(tmp_path, "-m", "tsd_cli", *words[1:], "--controller", "local")
    assert "file" in table
    assert len(errors_of(table, "com.y")) == 1
