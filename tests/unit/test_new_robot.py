"""The command that writes a proposed robot file: what it prints, and with which code it ends."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
import typer

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.robot import Robot
from tsd_cli.actions import new_robot
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.proposal import ProposalOptions

Write = Callable[..., Path]
FEET = "left_foot,right_foot"
LOW_KNEES = {"knee": "0 0.9"}


def write(path: Path, feet: str = FEET, json_file: str | None = None) -> Path:
    robot_file = path.parent / "small.yaml"
    options = ProposalOptions(feet=feet, out=robot_file)
    new_robot.write_new_robot(path, options, JsonOptions(json_file=json_file))
    return robot_file


def test_a_file_of_use_ends_well(small_humanoid: Write, capsys: pytest.CaptureFixture[str]) -> None:
    robot_file = write(small_humanoid())
    assert Robot(robot_file).name == "small"
    said = capsys.readouterr()
    assert said.out.splitlines()[-1] == f"next: tsd robot check {robot_file}"
    assert "is written, but" not in said.err


@pytest.mark.parametrize(
    ("limits", "feet", "told"),
    [
        (LOW_KNEES, FEET, "no room for any motion"),
        ({}, "right_foot,left_foot", "is LEFT really the left foot"),
    ],
)
def test_a_file_of_no_use_is_written_and_ends_with_one(
    small_humanoid: Write,
    limits: dict[str, str],
    feet: str,
    told: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = small_humanoid(limits=limits)
    with pytest.raises(typer.Exit) as left:
        write(path, feet)
    assert left.value.exit_code == 1
    assert Robot(path.parent / "small.yaml").name == "small"
    last = capsys.readouterr().err.splitlines()[-1]
    assert "small.yaml is written, but" in last
    assert told in last


def test_problems_are_in_the_json(small_humanoid: Write, tmp_path: Path) -> None:
    result = tmp_path / "result.json"
    with pytest.raises(typer.Exit):
        write(small_humanoid(limits=LOW_KNEES), json_file=str(result))
    (problem,) = json.loads(result.read_text())["problems"]
    assert "no room for any motion" in problem


def test_a_draft_that_does_not_load_is_told_by_the_name_of_the_file(
    small_humanoid: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path) -> None:
        raise RobotFileError(path, "links.hand", "is odd", f"other lines in {path.name}")

    monkeypatch.setattr(new_robot, "Robot", refuse)
    path = small_humanoid()
    with pytest.raises(RobotFileError, match="is odd") as caught:
        write(path)
    robot_file = path.parent / "small.yaml"
    assert f"{robot_file}: field" in str(caught.value)
    assert "other lines in small.yaml" in str(caught.value)
    assert ".small.yaml." not in str(caught.value)
    assert not robot_file.exists()
