"""What the report says of the runs at low and at high stiffness."""

from __future__ import annotations

from collections.abc import Mapping

from tsd_experiments.beyond.stiffness_or_feedforward.tables import NOISE
from tsd_experiments.harness.job import Result


def pushed_sentence(world: str, results: Mapping[str, Result], stiff: float) -> str:
    """Tell how far a downward push moves the soft and the stiff robot.

    Args:
        results: Of 'soft learned' and 'stiff none'.
        stiff: P of the stiff one [1/s^2].
    """
    low, high = (
        results[name].row("down")["peak_deflection_m"] for name in ("soft learned", "stiff none")
    )
    soft = "falls" if low is None else f"gives way by {1e3 * low:.1f} mm"
    hard = "falls" if high is None else f"by {1e3 * high:.2f} mm"
    shares = [
        results[name].row("down")["peak_torque_share"] for name in ("soft learned", "stiff none")
    ]
    return (
        f"{world}: pushed down, the soft robot with feedforward {soft}, the stiff one without "
        f"(P = {stiff:.3g}) {hard}; the largest torques are {100 * shares[0]:.0f} % and "
        f"{100 * shares[1]:.0f} % of what a motor can give."
    )


def shaken_sentence(world: str, results: Mapping[str, Result]) -> str:
    """Tell what torques the soft and the stiff robot add to noise on the joints.

    Args:
        results: Of 'soft learned' and 'stiff none'.
    """
    soft, stiff = (
        results[name].row("noise")["added_torque_rms_nm"] for name in ("soft learned", "stiff none")
    )
    if soft is None or stiff is None:
        return f"{world}: with {NOISE:g} N m of noise on the joints not both stay up."
    return (
        f"{world}: to {NOISE:g} N m of noise on the joints the soft one answers with "
        f"{soft:.2f} N m RMS, the stiff one with {stiff:.2f} N m."
    )


def same_limit_sentence(ratios: Mapping[str, float]) -> str:
    """Tell whether feedforward changes the highest stiffness that works.

    Args:
        ratios: Highest P with it by highest P without it, by world.
    """
    listed = ", ".join(f"{ratio:.2g} ({world})" for world, ratio in ratios.items())
    # a bisection cannot tell less than that apart
    same = all(0.8 <= ratio <= 1.25 for ratio in ratios.values())
    return (
        "Feedforward is no feedback and leaves stability as it is, "
        + ("which shows: " if same else "but what counts here is more than stability: ")
        + f"highest P with it by highest P without it is {listed}. A tick whose QP has no "
        "solution counts as not working, even if the robot stays up; feedforward and a large "
        "P ask for more acceleration together when the motion starts."
    )
