"""What is kept of every tick of a repetition: the fields of a log."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LogField:
    """One quantity of a log.

    Attributes:
        unit: SI units; empty for what has none.
        meaning: What it is, with its frame.
        shape: Of one tick: n joints, c contacts, k axes of the repetition, a axes of
            all tasks.
        type: NumPy's name of the numbers' type.
    """

    unit: str
    meaning: str
    shape: str = "()"
    type: str = "float64"


# in the order in which a repetition writes them down
LOG_FIELDS: dict[str, LogField] = {
    "time": LogField("s", "since the repetition began"),
    "phase": LogField("rad", "phase of the motion, growing from lap to lap"),
    "lap": LogField("", "number of the lap from 0 on; -1 while holding", type="int64"),
    "reference": LogField("m, rad", "of every axis, relative to the motion's middle", "(k,)"),
    "error": LogField("m, rad", "reference - place, as the controller sees it", "(k,)"),
    "true_error": LogField("m, rad", "the plant's own; NaN where nobody knows it", "(k,)"),
    "feedback": LogField("m/s^2, rad/s^2", "P e + D de/dt", "(k,)"),
    "feedforward": LogField("m/s^2, rad/s^2", "what was learned", "(k,)"),
    "all_errors": LogField("m, rad", "errors of all axes of all tasks", "(a,)", "float32"),
    "q": LogField(
        "m, -, rad",
        "true configuration: base position (world) and quaternion xyzw, joint angles",
        "(7 + n,)",
        "float32",
    ),
    "v": LogField(
        "m/s, rad/s",
        "true velocity: base linear and angular (base frame), joint velocities",
        "(6 + n,)",
        "float32",
    ),
    "tau": LogField("N m", "commanded joint torques, after every compensator", "(n,)", "float32"),
    "wrenches": LogField(
        "N, N m",
        "contact wrenches [force; moment] that the controller plans, sole frames or (points) world",
        "(6 c,)",
        "float32",
    ),
    "joint_limits": LogField(
        "",
        "what bounds each joint, negative from below: 0 nothing, 1 acceleration, 4 position, "
        "5 velocity; 3 one of the last two yielded; 7 past its position's limit and coming back "
        "faster than it has to, 8 past its velocity's",
        "(n,)",
        "int8",
    ),
    "status": LogField("", "how the tick ended, 0 is ok, -1 no answer; see wire.md", type="int64"),
    "compute_us": LogField("us", "time inside the compiled function"),
    "tick_us": LogField("us", "round trip of the tick as its client sees it"),
    "missed": LogField(
        "",
        "why the period had no answer: 1 nothing there, 2 error, 3 late, 4 refused; else 0",
        type="int64",
    ),
    "measured": LogField("", "whether the tick is in a lap that is measured", type="bool"),
}
