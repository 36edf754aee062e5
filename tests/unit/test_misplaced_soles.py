"""Soles of a robot file that are not where the feet are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tsd_casadi.examination.finding import Finding
from tsd_casadi.examination.misplaced_soles import MISPLACED, misplaced_soles
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


def test_feet_without_shapes_say_nothing(mini_biped: Robot) -> None:
    assert list(misplaced_soles(mini_biped)) == []
