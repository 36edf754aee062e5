"""Motions in files of somebody's own."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tsd_casadi import Robot, Squat
from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_casadi.motions.catalogue import find_motion
from tsd_casadi.motions.ranges import check_motion, range_of
from tsd_casadi.robot.robot import load_robot

OWN = '''
import math
from dataclasses import dataclass
import numpy as np
from tsd_casadi.motions.motion import Motion, Offset
from tsd_casadi.motions.parameter import parameter

@dataclass(frozen=True)
class Bounce(Motion):
    """Up and down, twice as fast on the way."""

    hop: float = parameter("m", "half of peak to peak", low=0.0, extent=True)
    frequency: float = parameter("Hz", "laps per second", default=0.5)

    name = "bounce"

    def axes(self, robot):
        return (robot.axis_for("bounce", "com", "z"),)

    def offset(self, phase):
        sine, cosine = np.sin([2 * phase]), np.cos([2 * phase])
        return Offset(self.hop * sine, 2 * self.hop * cosine, -4 * self.hop * sine)
'''

Write = Callable[..., str]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(*changes: tuple[str, str], name: str = "my_motion.py") -> str:
        text = OWN
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / name
        path.write_text(text)
        return f"{path}:Bounce"

    return write


def test_a_class_in_a_file_is_a_motion(write: Write, robot: Robot) -> None:
    kind = find_motion(write())
    motion = kind(**kind.declaration().complete({"hop": 0.02}))
    assert motion.parameters == {"hop": 0.02, "frequency": 0.5}
    assert motion.offset(math.pi / 4).x == pytest.approx([0.02])
    check_motion(robot, motion)
    # nobody said how far this robot can go
    low, high = range_of(robot, kind, kind.declaration().parameters[0])
    assert low == 0.0
    assert 0.02 < high < 0.5
    with pytest.raises(InvalidValue, match=r"hop is 0\.5"):
        check_motion(robot, kind(hop=0.5))


def test_an_edited_file_is_another_version(write: Write) -> None:
    first, same = find_motion(write()), find_motion(write(name="copy.py"))
    other = find_motion(write(("-4 * self.hop", "-4.0 * self.hop")))
    assert first.version == same.version != other.version
    assert find_motion("squat").version == "1"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ([("2 * self.hop * cosine", "self.hop * cosine")], r"by_phase of Bounce at phase 0 rad"),
        ([("-4 * self.hop", "4 * self.hop")], r"by_phase_twice of Bounce .*which differences give"),
        ([("[2 * phase]", "[0.5 * phase]")], "another after a lap"),
        ([("self.hop * sine, 2", "0.0, 2")], "of shapes"),
        ([("self.hop * sine, 2", "sine / 0.0, 2")], "x of Bounce is not finite"),
        ([("np.sin([", "np.sinn([")], "raising AttributeError.*expected no error"),
        ([('    name = "bounce"\n', "")], "Bounce is without name, expected all members"),
        ([("def axes", "def no_axes"), ("def offset", "def f")], "without axes and offset"),
        ([("(frozen=True)", "")], "no frozen dataclass"),
        ([("@dataclass(frozen=True)\n", "")], "no frozen dataclass"),
        ([('name = "bounce"', 'name = "Bounce!"')], "name of Bounce is 'Bounce!'"),
        ([('name = "bounce"', 'name = "squat"')], "'squat', which is shipped"),
        ([("frequency: float", "pace: float")], "Bounce is without frequency"),
        ([("    hop: float", "    kind: float"), ("self.hop", "self.kind")], "'kind'"),
        ([("frequency: float", "turns: int = 3\n    frequency: float")], "Bounce.turns is no"),
        ([("class Bounce", "class Jump")], "'Bounce', expected Jump"),
        ([("import math\n", "import maths\n")], "raises ModuleNotFoundError in line 2"),
        ([("import math\n", "import math (\n")], "raises SyntaxError in line 2"),
    ],
)
def test_what_cannot_be_learned_is_refused_by_name(
    write: Write, changes: list[tuple[str, str]], words: str
) -> None:
    name = write(*changes)
    with pytest.raises(InvalidValue, match=words):
        find_motion(name)


def test_a_class_that_is_no_motion_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.py"
    path.write_text("class Bounce: pass\n")
    with pytest.raises(InvalidValue, match="no subclass of Motion"):
        find_motion(f"{path}:Bounce")


def test_a_robot_file_may_narrow_it(write: Write, write_robot: Callable[..., Path]) -> None:
    kind = find_motion(write())
    path = write_robot(lambda document: document["motions"].update(bounce={"hop": [0.01, 0.02]}))
    narrowed = load_robot(path)
    with pytest.raises(InvalidValue, match=r"hop is 0\.03, expected 0\.01 to 0\.02 m"):
        check_motion(narrowed, kind(hop=0.03))
    check_motion(narrowed, Squat(0.03))  # others do not mind
    wrong = write_robot(lambda document: document["motions"].update(bounce={"hopp": [0.01, 0.02]}))
    with pytest.raises(RobotFileError, match=r"motions\.bounce\.hopp.*did you mean 'hop'"):
        check_motion(load_robot(wrong), kind(hop=0.02))


def test_it_may_use_what_lies_beside_it(write: Write, tmp_path: Path) -> None:
    (tmp_path / "sizes_of_bounces.py").write_text("HOP = 0.02\n")
    before = list(sys.path)
    kind = find_motion(
        write(
            ("import math\n", "from sizes_of_bounces import HOP\n"),
            ("low=0.0, extent", "low=0.0, default=HOP, extent"),
        )
    )
    assert kind.declaration().parameters[0].default == 0.02
    assert sys.path == before


@pytest.mark.parametrize("axis", ['"com.w"', '"com.z", "com.z"'])
def test_axes_that_are_none_are_refused(write: Write, robot: Robot, axis: str) -> None:
    kind = find_motion(write(('robot.axis_for("bounce", "com", "z"),', f"{axis},")))
    with pytest.raises(InvalidValue, match="axis of bounce is 'com"):
        check_motion(robot, kind(hop=0.02))
