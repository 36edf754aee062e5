"""What is noted of a tick, as fields of one row of numbers."""

from __future__ import annotations

from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.layout import Field, Layout


def row_layout(known: TickFormat, axes: int, nq: int) -> Layout:
    """Lay out everything that is known of a tick.

    Args:
        known: Of the controller.
        axes: Number k of axes of the repetition.
        nq: Size of the configuration.
    """
    n = len(known.joints)
    return Layout(
        (
            Field("time", 1, "s", "since the repetition began"),
            Field("phase", 1, "rad", "phase of the motion, growing from lap to lap"),
            Field("lap", 1, "", "number of the lap from 0 on; -1 while holding"),
            Field("share", 1, "", "how much of the learned term is phased in, 0 to 1"),
            Field("missed", 1, "", "why there was no answer, as in a log; 0 if there was one"),
            Field("tick_us", 1, "us", "round trip of the tick as its client sees it"),
            Field("reference", axes, "m, rad", "of the axes, relative to the motion's middle"),
            Field("true_error", axes, "m, rad", "the plant's own; NaN where nobody knows it"),
            Field("feedforward", axes, "m/s^2, rad/s^2", "added along the axes"),
            Field("tau", n, "N m", "commanded joint torques, after every compensator"),
            Field("q", nq, "m, -, rad", "configuration as measured"),
            Field("v", 6 + n, "m/s, rad/s", "velocity as measured"),
            Field("true_q", nq, "m, -, rad", "true configuration; NaN where nobody knows it"),
            Field("true_v", 6 + n, "m/s, rad/s", "true velocity; NaN where nobody knows it"),
            Field("reply", known.reply.size, "", "the controller's reply; NaN if there was none"),
        )
    )
