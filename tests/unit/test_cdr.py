"""Messages and their definitions against those of another implementation, rosbags."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tsd_clients.logs import ros_messages
from tsd_clients.logs.diagnostics import ERROR, OK, Diagnosis, diagnostic_array
from tsd_clients.logs.ros_messages import DEFINITIONS, TICK, TICK_FIELDS

STORE = get_typestore(Stores.ROS2_HUMBLE)
STORE.register(get_types_from_msg(DEFINITIONS[TICK], TICK))
names = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9)
numbers = st.floats(allow_nan=False)
stamps = st.tuples(st.integers(0, 2**31 - 1), st.integers(0, 10**9 - 1))
few = settings(max_examples=25)  # each is checked byte by byte


def header(stamp: tuple[int, int], frame: str) -> Any:
    time = STORE.types["builtin_interfaces/msg/Time"](*stamp)
    return STORE.types["std_msgs/msg/Header"](time, frame)


@pytest.mark.parametrize("kind", [kind for kind in DEFINITIONS if kind != TICK])
def test_definitions_are_those_of_ros(kind: str) -> None:
    theirs, _ = STORE.generate_msgdef(kind, ros_version=2)
    # the order of the parts and blank lines are free
    assert sorted(DEFINITIONS[kind].split("=" * 80)[0].split()) == sorted(
        theirs.split("=" * 80)[0].split()
    )
    ours, known = get_types_from_msg(DEFINITIONS[kind], kind), get_types_from_msg(theirs, kind)
    assert ours == known


@few
@given(st.lists(st.tuples(names, numbers, numbers, numbers), max_size=5), stamps)
def test_joint_states(
    joints: list[tuple[str, float, float, float]], stamp: tuple[int, int]
) -> None:
    called = [name for name, *_ in joints]
    values = np.array([each for _, *each in joints]).reshape(-1, 3).T.copy()
    theirs = STORE.types["sensor_msgs/msg/JointState"](header(stamp, ""), called, *values)
    message = ros_messages.joint_state(called)
    parts = dict(zip(("position", "velocity", "effort"), values[:, None], strict=True))
    ours = message.fill({"stamp": np.array([stamp]), **parts})
    assert ours == [bytes(STORE.serialize_cdr(theirs, "sensor_msgs/msg/JointState"))]


@few
@given(st.lists(names, max_size=4), stamps, st.randoms(use_true_random=False))
def test_transforms(frames: list[str], stamp: tuple[int, int], random: Any) -> None:
    places = [[random.random() for _ in range(7)] for _ in frames]
    kinds = STORE.types
    theirs = kinds["tf2_msgs/msg/TFMessage"](
        [
            kinds["geometry_msgs/msg/TransformStamped"](
                header(stamp, "world"),
                frame,
                kinds["geometry_msgs/msg/Transform"](
                    kinds["geometry_msgs/msg/Vector3"](*place[:3]),
                    kinds["geometry_msgs/msg/Quaternion"](*place[3:]),
                ),
            )
            for frame, place in zip(frames, places, strict=True)
        ]
    )
    message = ros_messages.transforms(frames)
    content = {f"placement of {i}": np.array([each]) for i, each in enumerate(places)}
    content |= {f"stamp of {i}": np.array([stamp]) for i in range(len(frames))}
    ours = message.fill(content or {"nothing": np.zeros(1)})
    assert ours == [bytes(STORE.serialize_cdr(theirs, "tf2_msgs/msg/TFMessage"))]


@few
@given(names, stamps, st.lists(numbers, min_size=6, max_size=6))
def test_wrenches(frame: str, stamp: tuple[int, int], wrench: list[float]) -> None:
    kinds = STORE.types
    vectors = [kinds["geometry_msgs/msg/Vector3"](*each) for each in (wrench[:3], wrench[3:])]
    theirs = kinds["geometry_msgs/msg/WrenchStamped"](
        header(stamp, frame), kinds["geometry_msgs/msg/Wrench"](*vectors)
    )
    ours = ros_messages.wrench(frame).fill(
        {"stamp": np.array([stamp]), "wrench": np.array([wrench])}
    )
    assert ours == [bytes(STORE.serialize_cdr(theirs, "geometry_msgs/msg/WrenchStamped"))]


@few
@given(
    st.lists(st.tuples(names, st.sampled_from([OK, ERROR]), names, st.dictionaries(names, names))),
    stamps,
    names,
)
def test_diagnostics(said: list[Any], stamp: tuple[int, int], robot: str) -> None:
    kinds = STORE.types
    theirs = kinds["diagnostic_msgs/msg/DiagnosticArray"](
        header(stamp, ""),
        [
            kinds["diagnostic_msgs/msg/DiagnosticStatus"](
                level,
                name,
                text,
                robot,
                [kinds["diagnostic_msgs/msg/KeyValue"](*each) for each in values.items()],
            )
            for name, level, text, values in said
        ],
    )
    ours = diagnostic_array(stamp, [Diagnosis(*each) for each in said], robot)
    assert ours == bytes(STORE.serialize_cdr(theirs, "diagnostic_msgs/msg/DiagnosticArray"))


@few
@given(st.integers(1, 4), st.integers(0, 5), st.randoms(use_true_random=False))
def test_ticks_come_back_from_both_readers(count: int, size: int, random: Any) -> None:
    shapes = {name: 1 if field.shape == "()" else size for name, field in TICK_FIELDS.items()}
    columns = {
        name: np.array([[random.uniform(-9, 9) for _ in range(width)] for _ in range(count)])
        for name, width in shapes.items()
    }
    message = ros_messages.tick(shapes)
    stamp = np.tile((7, 8), (count, 1))
    written = message.fill({"stamp": stamp, **columns})
    again = message.read(written)
    for number, each in enumerate(written):
        theirs = STORE.deserialize_cdr(each, TICK)
        assert (theirs.header.stamp.sec, theirs.header.stamp.nanosec) == (7, 8)
        for name, values in columns.items():
            np.testing.assert_array_equal(np.atleast_1d(getattr(theirs, name)), values[number])
            np.testing.assert_array_equal(again[name][number], values[number])


def test_a_message_of_another_size_is_refused() -> None:
    message = ros_messages.wrench("foot")
    with pytest.raises(ValueError, match="bytes"):
        message.read([message.content + b"\0"])
