"""What may have been meant by a length that is far out of range."""

from __future__ import annotations

# a digit too few behind the point, centimetres, millimetres
FACTORS = (10, 100, 1000)
# so many times the largest value: nearer ones are wishes rather than slips
FAR = 2.0


def likely_meant(value: float, low: float, high: float) -> str:
    """Ask for every length in the range that a slip may have turned into a value.

    Where two are as likely, both are named: 0.5 may be 0.05 m or 5 mm.

    Args:
        value: As given [m].
        low: Smallest length there is [m].
        high: Largest length there is [m].

    Returns:
        "; lengths are in metres: did you mean 0.05 or 0.005 m?", to be put
        behind a message; nothing if no such value is in the range.
    """
    if abs(value) <= FAR * max(abs(low), abs(high)):
        return ""
    meant = [f"{value / factor:g}" for factor in FACTORS if low <= value / factor <= high]
    return f"; lengths are in metres: did you mean {' or '.join(meant)} m?" if meant else ""
