"""The section of a robot file that says what the demonstration has to reach with it."""

from __future__ import annotations

from tsd_casadi.robot.robot_file_sections import Positive, Section


class DemoGoalsFile(Section):
    """How much better a squat has to become, as ratios of two runs of the demonstration.

    Attributes:
        rms_after_one: Least RMS error without feedforward over that after one iteration.
        ac_after_one: The same of the error without its mean.
        ac_after_two: The same after two iterations.
        feedback_after_one: Least mean feedback without over that after one iteration.
        rms_at_a_fifth: Least RMS error without, at P, over that learned at P, at P / 5.
        ac_constant: Bound of the error without its mean, without over a constant
            feedforward, which cannot help.
        ac_generalized: Largest error without its mean, generalised over learned.
        ac_by_nearest: Largest error without its mean, generalised over the nearest
            entry as it is.
        rms_perfect: Bound of the RMS error with a perfect model [mm].
    """

    rms_after_one: Positive = 80.0
    ac_after_one: Positive = 5.0
    ac_after_two: Positive = 25.0
    feedback_after_one: Positive = 80.0
    rms_at_a_fifth: Positive = 20.0
    ac_constant: Positive = 5.0
    ac_generalized: Positive = 1.5
    ac_by_nearest: Positive = 0.3
    rms_perfect: Positive = 0.02
