"""The job that pushes and shakes a robot at some stiffness."""

from __future__ import annotations

from typing import Any

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.repetition.repetition import HOLD
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_clients.simulator.disturbances import Disturbance, Push, TorqueNoise
from tsd_clients.simulator.state_map import StateMap
from tsd_experiments.beyond.stiffness_or_feedforward.run_at import run_at
from tsd_experiments.beyond.stiffness_or_feedforward.witness import Witness
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.outcome import TRACE_STEP, Outcome

PUSH_DURATION = 0.1  # s
# the third lap: two laps are steady before it in every case
PUSHED_LAP = 2
# in the middle of its first half, where the robot is lowest
PUSHED_AT = 0.25
RECOVERED = 1e-3  # m


class Until(Disturbance):
    """Another disturbance that ends at some time."""

    def __init__(self, end: float, disturbance: Disturbance) -> None:
        """Choose what ends when.

        Args:
            end: [s].
        """
        self._end = end
        self._disturbance = disturbance

    def reset(self) -> None:
        """Start again."""
        self._disturbance.reset()

    def apply(self, data: Any, state_map: StateMap, time: float) -> None:
        """Disturb while it lasts."""
        if time < self._end:
            self._disturbance.apply(data, state_map, time)


def disturb(
    robot: Robot,
    controller: WholeBodyController,
    case: dict[str, Any],
    factor: float,
    weights: list[float] | None,
    pushes: dict[str, list[float]],
    noise: float | None,
) -> Outcome:
    """Run the same undisturbed, pushed and with torque noise.

    Args:
        case: Plain data of the case; at least three laps.
        factor: On P.
        weights: Feedforward, (L,) [m/s^2].
        pushes: Impulse of each push, (3,) [N s].
        noise: Standard deviation on every joint [N m]; None to leave it out.

    Returns:
        Rows 'undisturbed', each push and 'noise'. Deflections, the distance to
        the undisturbed run's centre of mass, as '<push>/deflection' (N, 3) [m]
        from the push on, with '<push>/time' [s].
    """
    used = Case.of(case)
    outcome = Outcome()

    def run(*disturbances: Disturbance) -> tuple[Run, Witness]:
        return run_at(robot, controller, used, factor, weights, disturbances)

    calm, calm_witness = run()
    outcome.add("undisturbed", calm, **_loads(calm, calm_witness, 0, robot))
    start = HOLD + (PUSHED_LAP + PUSHED_AT) / used.frequency
    # a multiple of the time step
    start = round(start, 3)
    first = round(1e3 * start)
    for name, impulse in pushes.items():
        push = Push(start, PUSH_DURATION, (impulse[0], impulse[1], impulse[2]))
        pushed, witness = run(push)
        count = min(len(witness.com), len(calm_witness.com))
        deflection = (witness.com[:count] - calm_witness.com[:count])[first:]
        seen = deflection[::TRACE_STEP]
        outcome.arrays[f"{name}/deflection"] = seen
        ticks = np.arange(len(seen), dtype=float) * TRACE_STEP
        outcome.arrays[f"{name}/time"] = np.asarray(1e-3 * ticks, dtype=np.float64)
        outcome.rows.append(
            {
                "label": name,
                "fell": pushed.fell,
                "failures": pushed.failures,
                **_loads(pushed, witness, first, robot),
                **_response(deflection, np.array(impulse), pushed.fell),
            }
        )
    if noise is not None:
        # a run ends when it is steady, which it is not while it is shaken
        end = HOLD + used.laps / used.frequency
        shaken, witness = run(Until(end, TorqueNoise(noise)))
        # without the first lap, as everywhere
        late = slice(round(1e3 * (HOLD + 1 / used.frequency)), round(1e3 * end))
        added, torque = np.zeros(0), np.zeros(0)
        if not shaken.fell:
            away = witness.com[late] - calm_witness.com[late]
            added = np.sqrt((away**2).sum(axis=1))
            torque = np.asarray(shaken.log["tau"][late] - calm.log["tau"][late], dtype=float)
        outcome.rows.append(
            {
                "label": "noise",
                "fell": shaken.fell,
                "failures": shaken.failures,
                "added_rms_m": _rms(added),
                "added_torque_rms_nm": _rms(torque),
            }
        )
    return outcome


def _loads(run: Run, witness: Witness, first: int, robot: Robot) -> dict[str, float]:
    """Tell what ground and joints carry from a tick on."""
    torque = np.abs(run.log["tau"][first:]) / robot.torque_limit
    return {
        "peak_ground_force_n": float(witness.force[max(first, 1) :].max(initial=0.0)),
        "peak_torque_share": float(torque.max(initial=0.0)),
        "rms_torque_nm": float(np.sqrt(np.mean(run.log["tau"][first:].astype(float) ** 2))),
    }


def _response(deflection: Vector, impulse: Vector, fell: bool) -> dict[str, float | None]:
    """Tell peak and recovery along the push."""
    if fell:
        return {"peak_deflection_m": None, "recovery_s": None}
    along = deflection @ (impulse / np.linalg.norm(impulse))
    away = np.flatnonzero(np.abs(along) > RECOVERED)
    recovered = not away.size or away[-1] < len(along) - 1
    last = float(away[-1] + 1) * 1e-3 if away.size else 0.0
    return {
        "peak_deflection_m": float(np.max(np.abs(along), initial=0.0)),
        "recovery_s": last if recovered else None,
    }


def _rms(values: Vector) -> float | None:
    """Compute a root mean square; None of a run that fell."""
    return float(np.sqrt(np.mean(values**2))) if values.size else None
