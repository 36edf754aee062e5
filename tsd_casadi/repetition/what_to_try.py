"""What to try after a repetition that ended otherwise than it should."""

from __future__ import annotations

from tsd_casadi.repetition.run import Run
from tsd_casadi.tick.missed import Cause


def what_to_try(run: Run) -> list[str]:
    """Say what went wrong and what may help, a sentence each; nothing of a run that went well."""
    found = []
    if run.fell:
        found.append(f"after a fall try {_gentler(run)}")
    if run.failures:
        kinds = ", ".join(f"{count} {kind}" for kind, count in run.failures.items())
        found.append(
            f"the controller answered ticks with a safe torque ({kinds}): try {_gentler(run)}, or "
            "look at friction and limits of the robot file"
        )
    if run.at_limits:
        joints = ", ".join(f"{joint} in {count} ticks" for joint, count in run.at_limits.items())
        found.append(
            f"at a limit of position or velocity: {joints}; what is learned against a stop is "
            "about the stop. Try a smaller motion or another posture"
        )
    if not (run.steady or run.fell or run.aborted):
        found.append(
            f"the feedback did not settle in {run.laps_run} laps: try a larger P, a slower motion "
            "or more laps"
        )
    if run.missed and Cause.LATE.words in run.missed:
        found.append("answers came too late: try a slower pace")
    return found


def _gentler(run: Run) -> str:
    """Name what makes a motion easier, most promising first."""
    ways = ["a smaller or slower motion", "a larger P"]
    if run.feedforward.kind != "none":
        ways.append(f"none of the {run.feedforward.kind} feedforward")
    return f"{', '.join(ways[:-1])} or {ways[-1]}"
