"""Motions from files of references; what holds for every motion is in test_motions.py."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tsd_casadi import Robot
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.catalogue import find_motion
from tsd_casadi.motions.check_kind import check_offset
from tsd_casadi.motions.ranges import check_motion, range_of

DURATION = 4.0
TIME = np.linspace(0.0, DURATION, 81)
PHASE = 2 * math.pi * TIME / DURATION
COLUMNS = {
    "time": TIME,
    "com.z": 0.03 * np.sin(PHASE),
    "torso.rz": 0.1 * (1 - np.cos(2 * PHASE)),
}

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(name: str = "wave.csv", **changes: object) -> Path:
        columns = {**COLUMNS, **{key.replace("__", "."): value for key, value in changes.items()}}
        path = tmp_path / name
        if path.suffix == ".npz":
            np.savez(path, **columns)
            return path
        rows = zip(*(np.asarray(column).tolist() for column in columns.values()), strict=True)
        lines = [",".join(columns), *(",".join(map(str, row)) for row in rows)]
        path.write_text("\n".join(lines) + "\n")
        return path

    return write


@pytest.mark.parametrize("name", ["wave.csv", "wave.npz"])
def test_it_goes_through_its_points_with_exact_derivatives(write: Write, name: str) -> None:
    kind = find_motion(str(write(name)))
    motion = kind(**kind.declaration().complete({}))
    assert motion.parameters == {"scale": 1.0, "frequency": 0.25}
    check_offset(motion)
    for index in (0, 7, 40, 80):
        offset, phase = motion.offset(PHASE[index]), PHASE[index]
        assert offset.x == pytest.approx([COLUMNS["com.z"][index], COLUMNS["torso.rz"][index]])
        assert offset.by_phase[0] == pytest.approx(0.03 * math.cos(phase), abs=1e-5)
        assert offset.by_phase_twice[0] == pytest.approx(-0.03 * math.sin(phase), abs=1e-4)
    assert motion.offset(0.3 + 8 * math.pi).x == pytest.approx(motion.offset(0.3).x)


def test_scale_and_frequency_are_parameters(write: Write) -> None:
    kind = find_motion(str(write()))
    twice = kind(scale=2.0, frequency=0.5)
    assert twice.offset(1.0).x == pytest.approx(2 * kind().offset(1.0).x)
    assert twice.frequency == 0.5


def test_a_robot_knows_its_axes_and_how_far_it_may_go(write: Write, robot: Robot) -> None:
    kind = find_motion(str(write()))
    assert kind().axes(robot) == ("com.z", "torso.rz")
    check_motion(robot, kind())
    scale = kind.declaration().parameters[0]
    low, high = range_of(robot, kind, scale)
    assert low == 0.0
    assert 1.0 < high < 3.0
    with pytest.raises(InvalidValue, match="scale is 50"):
        check_motion(robot, kind(scale=50.0))


def test_other_numbers_are_another_version_and_the_same_are_not(write: Write) -> None:
    versions = [
        find_motion(str(path)).version
        for path in (
            write("one.csv"),
            write("two.npz"),
            write("three.csv", com__z=1.01 * COLUMNS["com.z"]),
        )
    ]
    assert versions[0] == versions[1] != versions[2]
    assert len({find_motion("squat").version, *versions}) == 3


def changed(column: str, index: int, value: float) -> dict[str, object]:
    values = COLUMNS[column].copy()
    values[index] = value
    return {column.replace(".", "__"): values}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (changed("com.z", 10, math.nan), "column 'com.z', value 11 is nan"),
        (changed("torso.rz", 3, math.inf), "column 'torso.rz', value 4 is inf"),
        (changed("time", 10, math.nan), "column 'time', value 11 is nan"),
        (changed("time", 10, 0.1), "time is 0.1 s after 0.45 s, expected times that grow"),
        (changed("com.z", -1, 0.01), "column 'com.z' is 0 at its start and 0.01 at its end"),
    ],
)
@pytest.mark.parametrize("name", ["wave.csv", "wave.npz"])
def test_numbers_that_are_no_lap_are_refused_by_name(
    write: Write, name: str, changes: dict[str, object], words: str
) -> None:
    with pytest.raises(InvalidValue, match=words):
        find_motion(str(write(name, **changes)))


def test_a_gap_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "gap.npz"
    np.savez(path, **{name: np.delete(values, slice(20, 30)) for name, values in COLUMNS.items()})
    with pytest.raises(InvalidValue, match=r"time is without anything from 0\.95 to 1\.5 s"):
        find_motion(str(path))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "empty"),
        ("com.z\n1\n", "columns is com.z, expected 'time'"),
        ("time\n1\n", "an axis as well"),
        ("time,com.z\n0,1\n1\n", "line 3 is of 1 cells, expected 2"),
        ("time,com.z\n0,\n", "column 'com.z', line 2 is '', expected a number"),
        ("time,com.z\n0,high\n", "'high', expected a number"),
        ("time,com.z,com.z\n0,1,1\n", "column 'com.z' is there twice"),
        ("time,com.z\n0,0\n1,0\n", "time is of 2 values"),
        ("time,z\n" + "".join(f"{i},0\n" for i in range(9)), "column 'z' is no axis"),
    ],
)
def test_tables_that_are_none_are_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "wave.csv"
    path.write_text(text)
    with pytest.raises(InvalidValue, match=words):
        find_motion(str(path))


def test_what_is_no_npz_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "wave.npz"
    path.write_bytes(b"nothing")
    with pytest.raises(InvalidValue, match=r"wave\.npz', which cannot be read"):
        find_motion(str(path))


def test_an_axis_that_the_robot_lacks_is_refused(write: Write, robot: Robot) -> None:
    kind = find_motion(str(write(hand__x=COLUMNS["com.z"])))
    with pytest.raises(InvalidValue, match=r"column is 'hand.x', expected an axis.*com\.z"):
        check_motion(robot, kind())


def test_without_a_file_there_is_nothing_to_do(robot: Robot) -> None:
    with pytest.raises(InvalidValue, match=r"wave\.csv"):
        check_motion(robot, find_motion("file")())


def test_ends_that_meet_but_for_rounding_are_one_point(write: Write) -> None:
    kind = find_motion(str(write(**changed("com.z", -1, 1e-5))))
    check_offset(kind())
    assert kind().offset(0.0).x[0] == kind().offset(2 * math.pi).x[0] == 0.0
