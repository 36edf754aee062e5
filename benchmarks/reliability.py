"""What becomes of a robot whose controller, or the way to it, goes away: the table of its goals.

    python -m benchmarks.reliability [KIND ...] [--times N] [--pace FACTOR] [--json FILE]

Kinds are calm (nothing happens: what is late then is late by this computer), kill (the
controller is killed and started again by the command line), stop (frozen and thawed), cut,
silence and delay (a TCP link between the two that closes, passes nothing, or is slow), and
hold, the robot left alone from a moving squat; all of them by default. Each of the first six
is one run of 'tsd simulate --pace' that is disturbed N times at random moments and ended by
Ctrl-C, its log and summary are looked at afterwards. The link is a program too and adds a
quarter of a millisecond to each answer. On a loaded computer choose a slow pace: a period
that this computer missed is 'late' and counts.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.disturbed_run import KINDS, DisturbedRun, Outcome
from benchmarks.held_posture import hold
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.torque_blend import LARGEST_STEP
from tsd_casadi.robot.robot import load_robot

READY_CPU = 1.0  # s
NEAR = 5e-3  # m
# the log keeps torques in 32 bits
ROUNDED = 1e-6
SHARES = tuple(place / 8 for place in range(8))


def goals_of(outcome: Outcome) -> list[tuple[str, str, str, bool]]:
    """Compare with the goals.

    Returns:
        (measure, goal, measured, met).
    """
    counted = f"{sum(outcome.missed.values())} of {outcome.periods}: " + (
        ", ".join(f"{count} {why}" for why, count in outcome.missed.items()) or "none"
    )
    rows = [
        ("falls", "0", str(int(outcome.fell)), not outcome.fell),
        (
            "torque step around gaps",
            f"<= {LARGEST_STEP:.0%} of the limit",
            f"{outcome.step:.2%} in {outcome.gaps} gaps",
            outcome.step <= LARGEST_STEP + ROUNDED,
        ),
        ("periods missed without a cause", "0", str(outcome.uncounted), outcome.uncounted == 0),
        ("periods missed", "told", counted, True),
    ]
    if outcome.kind == "kill":
        cpu = sorted(outcome.cpu)
        told = f"{cpu[len(cpu) // 2]:.2f} s, at most {cpu[-1]:.2f} s"
        rows.append(("CPU until ready", f"<= {READY_CPU:g} s", told, cpu[-1] <= READY_CPU))
    return rows


def disturb(kind: str, times: int, pace: float, seed: int, robot: str) -> Outcome:
    """Do one disturbed run.

    Args:
        kind: One of ``KINDS``.
    """
    with (
        tempfile.TemporaryDirectory() as folder,
        DisturbedRun(Path(folder), robot, pace) as run,
    ):
        return run.disturb(kind, times, random.Random(seed))


def hold_alone(robot: str) -> list[tuple[str, str, str, bool]]:
    """Hold at eight moments of a squat, with models that are wrong both ways."""
    loaded = load_robot(robot)
    controller = compile_controller(loaded)
    rows = []
    for error in (0.1, -0.1):
        held = [hold(loaded, controller, Squat(0.04, 0.5), error, share) for share in SHARES]
        end, worst = max(each.end for each in held), max(each.worst for each in held)
        told = f"{1e3 * end:.1f} mm, {1e3 * worst:.1f} mm on the way"
        rows.append((f"after 2 s, model error {error:+.0%}", "<= 5 mm", told, end <= NEAR))
    return rows


def main() -> int:
    """Print the table.

    Returns:
        0 if every goal is met, else 1.
    """
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    kinds = [*KINDS, "hold"]
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"of {', '.join(kinds)}")
    parser.add_argument("--times", type=int, default=20, metavar="N", help="default 20")
    parser.add_argument("--pace", type=float, default=1.0, metavar="FACTOR", help="default 1")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the moments")
    parser.add_argument("--robot", default="hermes_lower", metavar="NAME|FILE")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the outcomes there too")
    given = parser.parse_args()
    if unknown := set(given.kinds) - set(kinds):
        parser.error(f"no kind {', '.join(sorted(unknown))}; there are {', '.join(kinds)}")
    outcomes: dict[str, Any] = {}
    missed = 0
    for kind in given.kinds or kinds:
        if kind == "hold":
            title, rows = "hold alone from a moving squat of 4 cm", hold_alone(given.robot)
        else:
            outcome = disturb(kind, given.times, given.pace, given.seed, given.robot)
            outcomes[kind] = asdict(outcome)
            title = f"{kind}, {given.times} times, pace {given.pace:g}"
            rows = goals_of(outcome)
        print(
            f"\n{title} (away for {outcomes[kind]['away']:.0f} periods)"
            if kind in outcomes
            else f"\n{title}"
        )
        for measure, goal, measured, met in rows:
            missed += not met
            print(f"  {measure:32} {goal:22} {measured}{'' if met else '   MISSED'}", flush=True)
    if given.json is not None:
        given.json.write_text(json.dumps(outcomes, indent=2))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
