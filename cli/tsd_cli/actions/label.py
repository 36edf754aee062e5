"""Names of runs in tables."""

from __future__ import annotations

from tsd_casadi.repetition.run import Run


def label_of(run: Run) -> str:
    """Name a run by what tells it from others: 'squat 3 cm, learned, iteration 1, P x 0.2'."""
    parts = [f"{run.motion.name} {100 * run.motion.parameters['amplitude']:g} cm"]
    kind = run.feedforward.kind
    parts.append(f"{kind}, iteration {run.feedforward.iteration}" if kind != "none" else "none")
    if run.settings["p_scale"] != 1.0:
        parts.append(f"P x {run.settings['p_scale']:g}")
    if run.settings["hardware"]:
        parts.append("hardware")
    return ", ".join(parts)
