"""The job that runs a case with borrowed weights, without and with the gate."""

from __future__ import annotations

from typing import Any

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.robot.robot import Robot
from tsd_experiments.harness.outcome import Outcome
from tsd_experiments.harness.replay_case import replay_case


def replay_gated(
    robot: Robot, controller: WholeBodyController, case: dict[str, Any], weights: list[float]
) -> Outcome:
    """Run a case with borrowed weights twice, without and with the gate.

    Args:
        weights: (L,) [m/s^2].

    Returns:
        Rows 'ungated' and 'gated', the latter with 'dropped_at' [s] or None.
    """
    outcome = replay_case(robot, controller, case, weights=weights, kind="nearest", label="ungated")
    gate = FeedforwardGate()
    gated = replay_case(
        robot, controller, case, weights=weights, kind="nearest", label="gated", compensators=[gate]
    )
    gated.rows[0]["dropped_at"] = gate.dropped_at
    return Outcome(outcome.rows + gated.rows, {**outcome.arrays, **gated.arrays})
