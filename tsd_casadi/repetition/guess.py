"""Where the prediction of a linear loop is no more than a guess, and when that matters."""

from __future__ import annotations

# 7 % off at 7 cm, 40 % at 11 cm, where the knees are straight, in a squat with +10 %, P = 10 and
# P = 5
FAR = 0.05  # m
# so many times too large may a predicted error be there: those 40 %, with some margin
GUESS = 1.5


def is_doubtful(with_it: float, without_it: float) -> bool:
    """Say whether a term that seems to help may harm, since the robot would be far off.

    Args:
        with_it: RMS error with the term [m].
        without_it: The predicted one without it [m].
    """
    return without_it > FAR and GUESS * with_it > without_it


def caution(without_it: float) -> str:
    """Tell people what a predicted RMS error [m] is worth, after what was said of it."""
    if without_it < FAR:
        return ""
    return "; so far off, the robot lacks other torques than at its reference, and that is a guess"
