"""Whether a feedforward was learned in just this way, or is borrowed: named and gated then."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.learning.circumstances import tell_differences
from tsd_casadi.learning.context import UNKNOWN
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.check_served import check_served
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.robot.robot import Robot

# of gains and parameters: what writing numbers down and reading them may change
SAME = 1e-6


def gates_for(
    feedforward: Feedforward | None,
    robot: Robot,
    controller: WholeBodyController,
    motion: Motion,
    gains: Gains,
    correction: str,
) -> list[FeedforwardGate]:
    """Look again at what was served, and make the gate that what is borrowed needs.

    Args:
        feedforward: As served; None for none.
        robot: That will move, as its controller believes it.
        controller: That it will be used with.
        motion: That it will be used for.
        gains: Factors on the controller's gains.
        correction: Fingerprint of the centre of mass in use; empty for the model's.

    Returns:
        One gate, which names where the feedforward is from, or none for the
        motion's own.

    Raises:
        IncompatibleEntry: If it is not for the robot; see ``check_served``.
    """
    if feedforward is None:
        return []
    check_served(feedforward, robot, motion)
    name = name_borrowed(feedforward, motion, controller, gains, correction)
    return [] if name is None else [FeedforwardGate(name)]


def name_borrowed(
    feedforward: Feedforward,
    motion: Motion,
    controller: WholeBodyController,
    gains: Gains,
    correction: str,
) -> str | None:
    """Name a feedforward that was not learned in just this way, for people.

    Args:
        motion: That it will be used for.
        controller: That it will be used with.
        gains: Factors on the controller's gains.
        correction: Fingerprint of the centre of mass in use; empty for the model's.

    Returns:
        'the feedforward generalised from entries 1, 2'; None of one that is the
        motion's own.
    """
    told = feedforward.provenance
    reasons = []
    if feedforward.kind != "learned":
        reasons.append(feedforward.kind + _from(told.get("entries", ())))
        if differences := tell_differences(told.get("hardware", ())):
            reasons.append(f"learned on robots that differ ({differences})")
    else:
        reasons += [
            f"learned for {name} {value:g}"
            for name, value in feedforward.parameters.items()
            if abs(value - motion.parameters.get(name, value)) > SAME
        ]
    context = told.get("context")
    if context is not None:
        if UNKNOWN in (context["body"], context["formulation"]):
            reasons.append("learned for a body or formulation that nobody wrote down")
        if context["correction"] != correction:
            reasons.append(
                f"learned with {_corrected(context['correction'])}, used with "
                f"{_corrected(correction)}"
            )
    # of a generalised term those of each entry
    of_entries = told.get("gains", {})
    of_entries = of_entries if isinstance(of_entries, list) else [of_entries]
    for gain, used_at in _gains(controller, feedforward.axes, gains).items():
        others = [
            _numbers(each[gain])
            for each in of_entries
            if gain in each and not _are_same(each[gain], used_at)
        ]
        if others:
            learned_at = " and ".join(dict.fromkeys(others))
            reasons.append(f"learned at {gain} = {learned_at}, used at {_numbers(used_at)}")
    return f"the feedforward {', '.join(reasons)}" if reasons else None


def _are_same(some: Sequence[float], others: Sequence[float]) -> bool:
    return len(some) == len(others) and np.allclose(some, others, rtol=SAME)


def _gains(
    controller: WholeBodyController, axes: Sequence[str], gains: Gains
) -> dict[str, list[float]]:
    command, known = controller.command(), controller.format
    for task in dict.fromkeys(axis.rpartition(".")[0] for axis in axes):
        gains.scale(command, task)
    pairs = [axis.rpartition(".")[::2] for axis in axes]
    return {
        gain: [
            float(command[f"{task}.{gain}"][known.component_index(task, axis)])
            for task, axis in pairs
        ]
        for gain in ("P", "D")
    }


def _from(entries: Sequence[int]) -> str:
    if not entries:
        return ""
    names = ", ".join(str(each) for each in entries)
    return f" from {'entry' if len(entries) == 1 else 'entries'} {names}"


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(dict.fromkeys(f"{value:g}" for value in values))


def _corrected(correction: str) -> str:
    return f"the corrected centre of mass {correction[:6]}" if correction else "the model's own"
