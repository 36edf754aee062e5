"""The messages of a log as ROS 2 defines them, and one of our own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tsd_casadi.repetition.log_fields import LOG_FIELDS, LogField
from tsd_clients.logs.cdr import CdrMessage

WORLD = "world"
TICK = "tsd_msgs/msg/Tick"
# beyond LOG_FIELDS
MORE_FIELDS: dict[str, LogField] = {
    "share": LogField("", "how much of the learned term is phased in, 0 to 1"),
    "measured_q": LogField("m, -, rad", "configuration as measured", "(7 + n,)"),
    "measured_v": LogField("m/s, rad/s", "velocity as measured", "(6 + n,)"),
    "active": LogField("", "what each row of the QP is at; see wire.md", "(rows,)"),
}
# 'measured' is known at the end only
TICK_FIELDS = {
    **{name: field for name, field in LOG_FIELDS.items() if name != "measured"},
    **MORE_FIELDS,
}

_HEADER = """\
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id"""
_TIME = """\
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec"""
_VECTOR = """\
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z"""
_RULE = "\n" + 80 * "=" + "\n"


def _joined(*parts: str) -> str:
    return _RULE.join(parts) + "\n"


# from ROS 2 Humble; a type and what it is made of, as MCAP's schemas want it
DEFINITIONS: dict[str, str] = {
    "std_msgs/msg/String": "string data\n",
    "sensor_msgs/msg/JointState": _joined(
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
        "float64[] effort",
        _HEADER,
        _TIME,
    ),
    "tf2_msgs/msg/TFMessage": _joined(
        "geometry_msgs/TransformStamped[] transforms",
        "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
        "geometry_msgs/Transform transform",
        _HEADER,
        _TIME,
        "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
        "geometry_msgs/Quaternion rotation",
        _VECTOR,
        "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    ),
    "geometry_msgs/msg/WrenchStamped": _joined(
        "std_msgs/Header header\ngeometry_msgs/Wrench wrench",
        _HEADER,
        _TIME,
        "MSG: geometry_msgs/Wrench\ngeometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque",
        _VECTOR,
    ),
    "diagnostic_msgs/msg/DiagnosticArray": _joined(
        "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status",
        _HEADER,
        _TIME,
        "MSG: diagnostic_msgs/DiagnosticStatus\nbyte OK=0\nbyte WARN=1\nbyte ERROR=2\n"
        "byte STALE=3\nbyte level\nstring name\nstring message\nstring hardware_id\n"
        "diagnostic_msgs/KeyValue[] values",
        "MSG: diagnostic_msgs/KeyValue\nstring key\nstring value",
    ),
    TICK: _joined(
        "# a control tick; units and frames: docs/logs.md of tsd_casadi\n"
        "std_msgs/Header header\n"
        + "\n".join(
            f"float64{'' if field.shape == '()' else '[]'} {name}  # {field.meaning}"
            for name, field in TICK_FIELDS.items()
        ),
        _HEADER,
        _TIME,
    ),
}


def joint_state(joints: Sequence[str]) -> CdrMessage:
    """Leave 'stamp', 'position', 'velocity' and 'effort' of a JointState open."""
    message = _stamped("")
    message.add("I", len(joints))
    for joint in joints:
        message.add_string(joint)
    for name in ("position", "velocity", "effort"):
        message.add("I", len(joints))
        message.leave_open(name, "d", len(joints))
    return message


def transforms(frames: Sequence[str]) -> CdrMessage:
    """Leave 'stamp of N' and 'placement of N' of a TFMessage open, N counting frames.

    A placement is the position [m] and the orientation as a quaternion xyzw, in the world.
    """
    message = CdrMessage()
    message.add("I", len(frames))
    for number, frame in enumerate(frames):
        message.leave_open(f"stamp of {number}", "I", 2)
        message.add_string(WORLD)
        message.add_string(frame)
        message.leave_open(f"placement of {number}", "d", 7)
    return message


def wrench(frame: str) -> CdrMessage:
    """Leave 'stamp' and 'wrench', [force; moment], of a WrenchStamped open."""
    message = _stamped(frame)
    message.leave_open("wrench", "d", 6)
    return message


def tick(sizes: Mapping[str, int]) -> CdrMessage:
    """Leave 'stamp' and every field of a Tick open.

    Args:
        sizes: Number of components by field, of those that are arrays.
    """
    message = _stamped(WORLD)
    for name, field in TICK_FIELDS.items():
        if field.shape == "()":
            message.leave_open(name, "d", 1)
        else:
            message.add("I", sizes[name])
            message.leave_open(name, "d", sizes[name])
    return message


def string(text: str) -> bytes:
    """Write a String."""
    message = CdrMessage()
    message.add_string(text)
    return message.content


def _stamped(frame: str) -> CdrMessage:
    message = CdrMessage()
    # an int32 and a uint32; seconds stay positive until 2038 in both
    message.leave_open("stamp", "I", 2)
    message.add_string(frame)
    return message
