"""What learning cannot tell: where the true centre of mass is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tsd_casadi.center_of_mass.prior_deviation import UNMEASURED, prior_deviation
from tsd_casadi.robot.robot import Robot

# of the true error: less is no reason to say anything
NOTICEABLE = 0.02
REMEDY = "'tsd calibrate' measures it, --com-correction uses it"


def tell_prior(robot: Robot, axes: Sequence[str]) -> list[str]:
    """Say how far the centre of mass may be off that learning takes for true.

    Args:
        axes: Learned axes; without one of the centre of mass there is nothing to say.
    """
    coms = {part.name for part in robot.description.tasks if part.type == "com"}
    if not any(axis.rpartition(".")[0] in coms for axis in axes):
        return []
    deviation = float(np.linalg.norm(prior_deviation(robot, robot.home.q)))
    return [
        f"errors are those of the model's centre of mass. With each link's mass off by "
        f"{100 * UNMEASURED.mass:g} % and its centre by {1e3 * UNMEASURED.center:g} mm, each by "
        f"itself, the true one at home is {1e3 * deviation:.2g} mm away (one standard deviation), "
        f"whatever was learned. {REMEDY}"
    ]


def tell_risen(runs: Sequence[Mapping[str, Any]]) -> list[str]:
    """Say along which axes the true error rose, where a simulation knows it.

    Args:
        runs: Of one motion, from ``Run.summary``, in order; the first and the last
            that were measured are compared.
    """
    measured = [run["errors"] for run in runs if run["laps_measured"]]
    if len(measured) < 2:
        return []
    told = []
    for axis, last in measured[-1].items():
        first = measured[0].get(axis)
        if first is None or first["true_rms"] is None or last["true_rms"] is None:
            continue
        before, after = first["true_rms"], last["true_rms"]
        if after > (1 + NOTICEABLE) * before and last["rms"] < first["rms"]:
            unit = f"m{last['unit']}"
            told.append(
                f"the true error along {axis} rose from {1e3 * before:.3g} to {1e3 * after:.3g} "
                f"{unit} while the one that the controller sees fell from "
                f"{1e3 * first['rms']:.3g} to {1e3 * last['rms']:.3g} {unit}: the model is wrong "
                f"about where the robot is. {REMEDY}"
            )
    return told
