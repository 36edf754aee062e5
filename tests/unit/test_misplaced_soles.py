"""Soles of a robot file that are not where the feet are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from tsd_casadi.examination.finding import Finding
from tsd_casadi.examination.misplaced_soles import MISPLACED, misplaced_soles
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.proposal.propose import propose_robot_file
from tsd_casadi.robot.robot import Robot

Write = Callable[..., Path]
OFFSET = "offset: {xyz: [0.0, 0.0, -0.06], rpy: [0.0, 0.0, 0.0]}"


def findings(path: Path, *changes: tuple[str, str]) -> list[Finding]:
    """Propose a file, change its text, and look at its soles."""
    robot_file = path.parent / "small.yaml"
    text = propose_robot_file(path, ("left_foot", "right_foot"), (), "small", robot_file).text
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    robot_file.write_text(text)
    return list(misplaced_soles(Robot(robot_file)))


def test_a_proposed_sole_is_where_the_foot_is(small_humanoid: Write) -> None:
    assert findings(small_humanoid()) == []


@pytest.mark.parametrize(("off", "found"), [(0.9 * MISPLACED, 0), (1.1 * MISPLACED, 2)])
def test_a_sole_five_millimetres_off_is_an_error(
    small_humanoid: Write, off: float, found: int
) -> None:
    told = findings(small_humanoid(), (OFFSET, OFFSET.replace("-0.06", f"{off - 0.06:.5f}")))
    assert [finding.severity for finding in told] == ["error"] * found


def test_a_sole_a_centimetre_above_the_real_one_names_the_offset(small_humanoid: Write) -> None:
    told = findings(small_humanoid(), (OFFSET, OFFSET.replace("-0.06", "-0.05")))
    assert told[0].element == "contact left_foot"
    assert "10.0 mm above" in told[0].found
    assert "xyz: [0.0000, 0.0000, -0.0600]" in told[0].remedy


def test_an_ankle_taken_for_the_sole_is_told_so(small_humanoid: Write) -> None:
    told = findings(
        small_humanoid(), (f"    {OFFSET}  # m, rad; from there to the sole, z up\n", "")
    )
    assert "is at the ankle, 60.0 mm above" in told[0].found


def test_a_sole_larger_than_the_foot_is_a_warning(small_humanoid: Write) -> None:
    told = findings(small_humanoid(), ("x: [-0.06, 0.12]", "x: [-0.06, 0.14]"))
    assert [finding.severity for finding in told] == ["warning", "warning"]
    assert "by 10.0 mm" in told[0].found


@pytest.mark.parametrize(
    ("x", "y", "severity"),
    [
        # 2 cm of 20 cm; a fifth of 8 cm is 16 mm
        ([-0.06, 0.149], None, "warning"),
        ([-0.06, 0.151], None, "error"),
        (None, [-0.055, 0.055], "warning"),
        (None, [-0.057, 0.057], "error"),
    ],
)
def test_a_sole_far_larger_than_the_foot_is_an_error(
    small_humanoid: Write, x: list[float] | None, y: list[float] | None, severity: str
) -> None:
    told = findings(
        small_humanoid(),
        ("x: [-0.06, 0.12]", f"x: {x or [-0.06, 0.12]}"),
        ("y: [-0.036, 0.036]", f"y: {y or [-0.036, 0.036]}"),
    )
    assert [finding.severity for finding in told] == [severity] * 2


def test_a_sole_in_millimetres_is_told_so(small_humanoid: Write) -> None:
    told = findings(
        small_humanoid(),
        ("x: [-0.06, 0.12]", "x: [-64, 98]"),
        ("y: [-0.036, 0.036]", "y: [-36, 36]"),
    )
    assert [finding.severity for finding in told] == ["error", "error"]
    assert "is 162 m long" in told[0].found
    assert "x: [-0.064, 0.098], y: [-0.036, 0.036] if these are millimetres" in told[0].remedy


def test_feet_without_shapes_may_be_in_millimetres(mini_biped: Robot, tmp_path: Path) -> None:
    for file in mini_biped.path.parent.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    robot_file = tmp_path / mini_biped.path.name
    document = yaml.safe_load(robot_file.read_text())
    for contact in document["contacts"]:
        contact["x"] = [1e3 * length for length in contact["x"]]
    robot_file.write_text(yaml.safe_dump(document))
    told = list(misplaced_soles(Robot(robot_file)))
    assert [finding.severity for finding in told] == ["error", "error"]


def test_one_offset_that_differs_is_told_with_all_of_the_difference(small_humanoid: Write) -> None:
    path = small_humanoid()
    robot_file = path.parent / "small.yaml"
    text = propose_robot_file(path, ("left_foot", "right_foot"), (), "small", robot_file).text
    robot_file.write_text(text.replace(OFFSET, OFFSET.replace("-0.06", "-0.05"), 1))
    with pytest.raises(
        RobotFileError, match=r"leaves left_foot 10\.0 mm above right_foot"
    ) as caught:
        Robot(robot_file)
    assert "tilted" not in str(caught.value)
    assert "'offset'" in caught.value.expected


def test_feet_without_shapes_say_nothing(mini_biped: Robot) -> None:
    assert list(misplaced_soles(mini_biped)) == []
