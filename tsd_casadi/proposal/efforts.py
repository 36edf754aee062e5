"""Torque limits where a description has none: MJCF without motors."""

from __future__ import annotations

from typing import Any

import numpy as np

from tsd_casadi.proposal.body import Body
from tsd_casadi.proposal.home_posture import HomePosture
from tsd_casadi.proposal.inverse_statics import torque_shares
from tsd_casadi.state import Vector

# a limit this large is none [N m]
UNKNOWN = 1e6
# what stands for one that is not written
NONE = 1e9
# of the torque that crouching takes: motors of the public humanoids have 3 to 6 times as much
SPARE = 5.0
# of weight times height of the centre of mass, for joints that crouching does not load: a
# wrist of G1 has 0.025
LEAST = 0.02


def known_limits(model: Any, moment: float) -> Vector:
    """Collect the joints' torque limits.

    Args:
        moment: What stands in where there is none, weight times height [N m].

    Returns:
        (n,) [N m].
    """
    limits = np.array(model.upperEffortLimit[6:], dtype=float)
    return np.where(unknown(model), moment, limits)


def unknown(model: Any) -> Any:
    """Tell which joints have no torque limit, (n,)."""
    limits = np.array(model.upperEffortLimit[6:], dtype=float)
    return ~(np.isfinite(limits) & (limits < UNKNOWN))


def assumed_limits(body: Body, home: HomePosture) -> dict[str, float]:
    """Assume torque limits for the joints that have none, by joint [N m]."""
    missing = unknown(body.model)
    if not missing.any():
        return {}
    shares = [torque_shares(body, each.q, np.zeros(body.model.nv)) for each in home.family]
    largest = np.max([share for share in shares if share is not None], axis=0) * body.limit
    least = LEAST * body.mass * 9.81 * home.posed.height
    return {
        str(body.model.names[2 + index]): _rounded_up(max(SPARE * largest[index], least))
        for index in map(int, np.flatnonzero(missing))
    }


def _rounded_up(value: float) -> float:
    digit = 10.0 ** np.floor(np.log10(value))
    return float(np.ceil(value / digit) * digit)
