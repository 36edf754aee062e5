"""What a log says, in short: recomputed from its ticks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.tick.format import Status
from tsd_casadi.tick.missed import Cause
from tsd_casadi.tick.row_state import AT_LIMIT
from tsd_clients.logs.log import Log


def summarize_log(log: Log) -> dict[str, Any]:
    """Tell what a log is of and how it went, as plain data for JSON.

    Measures are those of the ticks in the log, also where it was cut; null where
    nothing was measured or nobody knows.
    """
    fields, outline = log.fields, log.outline
    time, measured, missed = fields["time"], fields["measured"], fields["missed"]
    joints = (
        tuple(map(str, range(fields["tau"].shape[1]))) if outline is None else outline.known.joints
    )
    at_limits = np.isin(np.abs(fields["joint_limits"]), AT_LIMIT).sum(axis=0)
    answered = fields["tick_us"][missed == 0]
    return {
        "robot": log.robot or None,
        "motion": None if outline is None else outline.motion,
        "parameters": {} if outline is None else outline.parameters,
        "feedforward": log.summary.get("feedforward"),
        "axes": list(log.axes),
        "learned": list(log.learned),
        "period_s": _period(log),
        "ticks": log.ticks,
        "from_s": float(time[0]) if log.ticks else None,
        "to_s": float(time[-1]) if log.ticks else None,
        "laps_run": log.laps_run,
        "laps_measured": len(np.unique(fields["lap"][measured])),
        "errors": _errors(log),
        "steady": log.summary.get("steady"),
        "fell": log.summary.get("fell"),
        "aborted": log.summary.get("aborted"),
        "failures": {
            each.name.lower(): int(np.sum(fields["status"] == each))
            for each in Status
            if each is not Status.OK and np.any(fields["status"] == each)
        },
        "missed": {
            cause.words: int(np.sum(missed == cause)) for cause in Cause if np.any(missed == cause)
        },
        "at_limits": {
            joint: count for joint, count in zip(joints, at_limits.tolist(), strict=True) if count
        },
        "vetoes": log.summary.get("vetoes", []),
        "tick_us": {
            name: float(np.percentile(answered, share)) if answered.size else None
            for name, share in (("p50", 50), ("p99", 99), ("max", 100))
        },
    }


def _errors(log: Log) -> dict[str, dict[str, Any]]:
    return {
        axis: {
            "unit": unit_of_axis(axis),
            **{
                name: None if value is None or math.isnan(value) else value
                for name, value in vars(error).items()
            },
        }
        for axis, error in log.errors.items()
    }


def _period(log: Log) -> float | None:
    if log.outline is not None:
        return log.outline.period
    time = log.fields["time"]
    return float(np.median(np.diff(time))) if log.ticks > 1 else None
