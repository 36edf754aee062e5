from __future__ import annotations

from pathlib import Path

import pytest

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.strict_yaml import DEEPEST, LARGEST_FILE, read_yaml


def read(tmp_path: Path, text: str) -> dict[str, object]:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    return read_yaml(path)


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("a: 1\nb: 2\na: 3\n", 3, "'a' is there already, in line 1"),
        ("a:\n  b: 1\n  b: 1\n", 3, "'b' is there already"),
        ("a: 010\n", 1, "octal"),
        ("a: -017\n", 1, "octal"),
        ("x: 1\na: 08\n", 2, "octal"),
        ("a: 1:30\n", 1, "base of 60"),
        ("a: [1, 12:30:45.5]\n", 1, "base of 60"),
        ("no: 1\n", 1, "no without quotes is a truth value"),
        ("a: {On: 1}\n", 1, "On without quotes is a truth value"),
        ("\n\na: off\n", 3, "off without quotes"),
        ("a: &a [*a]\n", 1, "alias"),
    ],
)
def test_what_yaml_would_read_as_something_else_is_refused_by_line(
    text: str, line: int, said: str, tmp_path: Path
) -> None:
    with pytest.raises(RobotFileError) as caught:
        read(tmp_path, text)
    assert caught.value.field == f"line {line}"
    assert said in str(caught.value)


def test_the_same_in_quotes_is_what_is_written(tmp_path: Path) -> None:
    text = 'no_1: "no"\n"off": "010"\na: "1:30"\n'
    assert read(tmp_path, text) == {"no_1": "no", "off": "010", "a": "1:30"}


def test_numbers_are_what_they_look_like(tmp_path: Path) -> None:
    text = "a: 0\nb: 0.5\nc: 1e-6\nd: -2E3\ne: -1\nf: 100\ng: 00\nh: true\n"
    expected = {"a": 0, "b": 0.5, "c": 1e-6, "d": -2e3, "e": -1, "f": 100, "g": 0, "h": True}
    assert read(tmp_path, text) == expected


def test_an_alias_is_what_it_stands_for(tmp_path: Path) -> None:
    assert read(tmp_path, "a: &x [1, 2]\nb: *x\n") == {"a": [1, 2], "b": [1, 2]}


def test_aliases_of_aliases_do_not_grow_without_bound(tmp_path: Path) -> None:
    lines = ["a0: &a0 [1, 1]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 60)]
    with pytest.raises(RobotFileError, match="too many aliases"):
        read(tmp_path, "\n".join(lines))


def test_nesting_has_an_end(tmp_path: Path) -> None:
    def nested(depth: int) -> str:
        return "a: " + "[" * depth + "]" * depth

    read(tmp_path, nested(DEEPEST - 1))
    for depth in (DEEPEST, 100_000):
        with pytest.raises(RobotFileError, match="nested too deeply"):
            read(tmp_path, nested(depth))


def test_a_file_that_is_no_robot_file_by_its_size_is_not_parsed(tmp_path: Path) -> None:
    comment = "a: 1\n#"
    read(tmp_path, comment + "x" * (LARGEST_FILE - len(comment)))
    with pytest.raises(RobotFileError, match="too large"):
        read(tmp_path, comment + "x" * (LARGEST_FILE - len(comment) + 1))


@pytest.mark.parametrize(
    "text",
    ["a:\n\tb: 1\n", "a: 1\nb:\n  - 1\n\t- 2\n", "\t- a\n", "a:\n  b: 1\n \tc: 2\n"],
)
def test_a_tab_is_called_a_tab(text: str, tmp_path: Path) -> None:
    with pytest.raises(RobotFileError, match=r"expected spaces where line \d has a tab"):
        read(tmp_path, text)


def test_what_no_tab_is_to_blame_for_is_not_blamed_on_one(tmp_path: Path) -> None:
    with pytest.raises(RobotFileError, match="is not YAML") as caught:
        read(tmp_path, 'a: ["x\ty", 2\nb: 1\n')
    assert "tab" not in caught.value.expected


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ('<?xml version="1.0"?>\n<!-- legs: two -->\n<robot name="r">\n</robot>\n', "a URDF"),
        ('<robot name="r"></robot>', "a URDF"),
        ('\ufeff\n<mujoco model="r"/>', "an MJCF"),
        ("<sdf/>", "XML"),
        (f'<robot name="r">{" " * LARGEST_FILE}</robot>', "a URDF"),
    ],
    ids=["commented", "urdf", "mjcf", "other", "large"],
)
def test_a_description_is_not_taken_for_a_robot_file(text: str, kind: str, tmp_path: Path) -> None:
    with pytest.raises(RobotFileError, match=f"is {kind}, no robot file") as caught:
        read(tmp_path, text)
    assert f"'tsd robot new {caught.value.path} --feet LEFT,RIGHT'" in str(caught.value)
