from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Command, InverseDynamics, Robot, State, load_robot
from tsd_casadi.exceptions import UnknownField
from tsd_casadi.motions.hold import hold
from tsd_casadi.repetition.references import References
from tsd_casadi.state import Vector
from tsd_casadi.tick.format import TickFormat

STEP = 1e-5
HAND = ("hand.x", "hand.y", "hand.z", "hand.rx", "hand.ry", "hand.rz")
# an order that is nobody's, and two tasks that turn
MIXED = ("torso.rz", "com.z", "hand.ry", "com.x", "hand.z", "torso.rx", "hand.rz", "hand.x")


class Asked:
    """A robot with a third frame task of all axes, and references of some axes."""

    def __init__(self, robot: Robot, tick_format: TickFormat, axes: Sequence[str]) -> None:
        self.robot, self.format, self.axes = robot, tick_format, axes
        self.command = Command(tick_format.request)
        # about a posture that is not upright
        q = robot.home.q.copy()
        q[3:7] = np.array([0.1, -0.2, 0.3, 0.9]) / np.linalg.norm([0.1, -0.2, 0.3, 0.9])
        self.middle = State(q, robot.home.v)
        hold(self.command, robot, self.middle)
        self.resting = self.command.copy()
        self.references = References(robot, tick_format, self.command, axes)

    def write(self, x: Vector, xd: Vector, xdd: Vector, feedforward: Vector | None = None) -> None:
        nothing = np.zeros(len(self.axes))
        self.references.write(x, xd, xdd, nothing if feedforward is None else feedforward)

    def placement(self, task: str) -> Any:
        """Where the reference is; without a turn for the centre of mass."""
        reference = self.command[f"{task}.reference"]
        turn = np.eye(3) if len(reference) == 3 else pinocchio.Quaternion(reference[3:]).matrix()
        return reference[:3].copy(), turn

    def controlled(self, task: str) -> list[int]:
        order = ("x", "y", "z", "rx", "ry", "rz")
        return [order.index(axis) for owner, axis in self.format.axes if owner == task]


@pytest.fixture(scope="module")
def with_hand(tmp_path_factory: pytest.TempPathFactory, robot: Robot) -> tuple[Robot, TickFormat]:
    folder = tmp_path_factory.mktemp("robots")
    for path in robot.path.parent.iterdir():
        if path.is_file():
            (folder / path.name).write_bytes(path.read_bytes())
    path = folder / robot.path.name
    line = "  - {type: frame, name: hand, frame: L_sole, P: 100.0, D: 20.0, W: 1.0}\n"
    path.write_text(path.read_text().replace("\nposture:", f"{line}\nposture:", 1))
    loaded = load_robot(path)
    return loaded, InverseDynamics(loaded).format


@pytest.fixture(scope="module", params=[HAND, MIXED], ids=["one task", "several tasks"])
def asked(request: pytest.FixtureRequest, with_hand: tuple[Robot, TickFormat]) -> Asked:
    return Asked(*with_hand, request.param)


def path(seed: int, k: int, size: float) -> tuple[Callable[[float], Vector], ...]:
    """Smooth offsets of k axes with their derivatives."""
    rng = np.random.default_rng(seed)
    a, b, w = rng.uniform(-size, size, (2, k)), rng.uniform(-size, size, k), rng.uniform(1, 4, k)

    def x(t: float) -> Vector:
        return a[0] + a[1] * t + b * np.sin(w * t)

    def xd(t: float) -> Vector:
        return a[1] + b * w * np.cos(w * t)

    def xdd(t: float) -> Vector:
        return -b * w**2 * np.sin(w * t)

    return x, xd, xdd


@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-6, 1e-2, 0.3, 1.0]))
def test_velocities_and_accelerations_are_those_of_the_references(
    asked: Asked, seed: int, size: float
) -> None:
    x, xd, xdd = path(seed, len(asked.axes), size)
    tasks = dict.fromkeys(axis.rpartition(".")[0] for axis in asked.axes)

    def at(t: float) -> dict[str, tuple[Any, Vector, Vector]]:
        asked.write(x(t), xd(t), xdd(t))
        return {
            task: (
                asked.placement(task),
                asked.command[f"{task}.reference_velocity"].copy(),
                asked.command[f"{task}.reference_acceleration"].copy(),
            )
            for task in tasks
        }

    before, now, after = at(-STEP), at(0.0), at(STEP)
    for task in tasks:
        (p0, R0), v0, _ = before[task]
        _, v, a = now[task]
        (p1, R1), v1, _ = after[task]
        moved = np.concatenate((p1 - p0, pinocchio.log3(R1 @ R0.T))) / (2 * STEP)
        np.testing.assert_allclose(v, moved[asked.controlled(task)], atol=1e-6 + 1e-5 * size)
        np.testing.assert_allclose(a, (v1 - v0) / (2 * STEP), atol=1e-6 + 1e-5 * size)


@given(seed=st.integers(0, 2**32 - 1))
def test_offsets_are_rotation_vectors_in_world_axes_about_the_middle(
    asked: Asked, seed: int
) -> None:
    x, xd, xdd = (each(0.3) for each in path(seed, len(asked.axes), 1.0))
    asked.write(x, xd, xdd)
    by_name = dict(zip(asked.axes, x, strict=True))
    for task in dict.fromkeys(axis.rpartition(".")[0] for axis in asked.axes):
        offset = np.array(
            [by_name.get(f"{task}.{axis}", 0.0) for axis in ("x", "y", "z", "rx", "ry", "rz")]
        )
        resting = asked.resting[f"{task}.reference"]
        p, R = asked.placement(task)
        np.testing.assert_allclose(p, resting[:3] + offset[:3], atol=1e-14)
        if len(resting) == 7:
            middle = pinocchio.Quaternion(resting[3:]).matrix()
            np.testing.assert_allclose(R, pinocchio.exp3(offset[3:]) @ middle, atol=1e-12)


def test_nothing_else_of_the_command_is_touched(asked: Asked) -> None:
    k = len(asked.axes)
    asked.write(*np.random.default_rng(1).uniform(-0.3, 0.3, (3, k)), np.arange(1.0, k + 1))
    tasks = {axis.rpartition(".")[0] for axis in asked.axes}
    moved = ("reference", "reference_velocity", "reference_acceleration", "feedforward")
    for name in asked.command.fields:
        task, _, field = name.partition(".")
        if task in tasks and field in moved:
            continue
        np.testing.assert_array_equal(asked.command[name], asked.resting[name], err_msg=name)
    # feedforward of every axis is where the controller looks for it, and nowhere else
    found = {}
    for task in tasks:
        names = [axis for owner, axis in asked.format.axes if owner == task]
        values = asked.command[f"{task}.feedforward"]
        found |= {f"{task}.{name}": u for name, u in zip(names, values, strict=True)}
    expected = dict.fromkeys(found, 0.0) | dict(zip(asked.axes, np.arange(1.0, k + 1), strict=True))
    assert found == expected
    # and back: no trace of what was
    nothing = np.zeros(k)
    asked.write(nothing, nothing, nothing)
    np.testing.assert_allclose(asked.command.request, asked.resting.request, atol=1e-15)


def test_a_shift_moves_the_centre_of_mass_alone_until_the_next_write(asked: Asked) -> None:
    k = len(asked.axes)
    motion = np.random.default_rng(2).uniform(-0.1, 0.1, (3, k))
    asked.write(*motion)
    before = asked.command.copy()
    asked.references.shift(np.array([0.01, -0.02, 0.03]), np.array([0.1, 0.2, 0.3]))
    off = asked.command.request - before.request
    places = asked.format.request.slices
    np.testing.assert_allclose(off[places["com.reference"]], [0.01, -0.02, 0.03], atol=1e-15)
    np.testing.assert_allclose(off[places["com.reference_velocity"]], [0.1, 0.2, 0.3], atol=1e-15)
    assert np.count_nonzero(off) == 6
    asked.write(*motion)
    np.testing.assert_array_equal(asked.command.request, before.request)


@given(seed=st.integers(0, 2**32 - 1))
def test_errors_are_offsets_and_rotation_vectors_from_the_robot_to_the_reference(
    asked: Asked, seed: int
) -> None:
    robot, rng = asked.robot, np.random.default_rng(seed)
    asked.write(*rng.uniform(-0.5, 0.5, (3, len(asked.axes))))
    q = pinocchio.integrate(robot.model, asked.middle.q, rng.uniform(-0.2, 0.2, robot.nv))
    com = robot.center_of_mass(q)
    found = asked.references.errors(State(q, robot.home.v), com)
    frames = {task.name: getattr(task, "frame", None) for task in robot.description.tasks}
    for axis, error in zip(asked.axes, found, strict=True):
        task, _, name = axis.rpartition(".")
        p, R = asked.placement(task)
        if frames[task] is None:
            off = np.append(p - com, np.zeros(3))
        else:
            position, quaternion = robot.frame_placement(frames[task], q)
            turn = R @ pinocchio.Quaternion(quaternion).matrix().T
            off = np.append(p - position, pinocchio.log3(turn))
        assert error == pytest.approx(off[("x", "y", "z", "rx", "ry", "rz").index(name)], abs=1e-12)


@pytest.mark.parametrize("axis", ["com.rx", "torso.z", "feet.z", "z", "com.", ""])
def test_an_axis_that_no_task_has_is_refused_with_those_that_there_are(
    with_hand: tuple[Robot, TickFormat], axis: str
) -> None:
    with pytest.raises(UnknownField, match=r"there are com\.x, com\.y, com\.z, pelvis\.rx") as e:
        Asked(*with_hand, ("com.z", axis))
    assert e.value.name in (axis, axis.lstrip("."))
