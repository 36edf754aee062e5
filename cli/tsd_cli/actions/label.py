"""Names of runs in tables."""

from __future__ import annotations

from tsd_casadi.motions.motion import Motion, declared_parameters
from tsd_casadi.repetition.run import Run


def label_of(run: Run) -> str:
    """Name a run by what tells it from others: 'squat 3 cm, learned, iteration 1, P x 0.2'."""
    parts = [describe_motion(run.motion)]
    kind = run.feedforward.kind
    parts.append(f"{kind}, iteration {run.feedforward.iteration}" if kind != "none" else "none")
    if run.settings["p_scale"] != 1.0:
        parts.append(f"P x {run.settings['p_scale']:g}")
    if run.settings.get("hardware"):
        parts.append("hardware")
    return ", ".join(parts)


def describe_motion(motion: Motion) -> str:
    """Name a motion and how far it goes: 'squat 3 cm', 'twist 0.15 rad', 'file'."""
    parts = [motion.name]
    for item in declared_parameters(type(motion)):
        value = motion.parameters[item.name]
        if item.extent and value != item.default:
            parts.append(f"{100 * value:g} cm" if item.unit == "m" else f"{value:g} {item.unit}")
    return " ".join(parts)
