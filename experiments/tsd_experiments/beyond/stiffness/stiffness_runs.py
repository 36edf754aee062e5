"""Runs at any stiffness, pushed and shaken; named by jobs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.repetition import HOLD
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_clients.simulator.disturbances import Disturbance, Push, TorqueNoise
from tsd_clients.simulator.state_map import StateMap
from tsd_experiments.harness.case import TRACE_STEP, Case, Outcome, feedforward_of

PUSH_DURATION = 0.1  # s
# the third lap: two laps are steady before it in every case
PUSHED_LAP = 2
# in the middle of its first half, where the robot is lowest
PUSHED_AT = 0.25
RECOVERED = 1e-3  # m
BISECTIONS = 3
# measured at the end of a run [s]
END = 1.0


class Stiffness(Compensator):
    """P times a factor of any size, with the damping ratio kept."""

    def __init__(self, factor: float) -> None:
        """Choose the stiffness.

        Args:
            factor: On P of the learned task's axes.
        """
        self._factor = factor

    def start(self, setting: Setting) -> None:
        """Note the task."""
        self._task = setting.task
        self._set = False

    def before(self, moment: Moment) -> None:
        """Set the gains at the first tick; they stay."""
        if not self._set:
            moment.command[f"{self._task}.P"] *= self._factor
            moment.command[f"{self._task}.D"] *= math.sqrt(self._factor)
            self._set = True


class Witness(Disturbance):
    """Adds nothing; notes the centre of mass and what the ground carries.

    The constraint forces on the base's translation are all external ones, those
    of the ground, for joints' friction and limits act on joints only.
    """

    def __init__(self) -> None:
        """Start with nothing."""
        self.reset()

    def reset(self) -> None:
        """Forget the run before."""
        self._com: list[Vector] = []
        self._force: list[float] = []

    @property
    def com(self) -> Vector:
        """True centre of mass at each tick, (N, 3) [m], world frame."""
        return np.array(self._com)

    @property
    def force(self) -> Vector:
        """Norm of the ground's force during the step before each tick, (N,) [N]."""
        return np.array(self._force)

    def apply(self, data: Any, state_map: StateMap, time: float) -> None:
        """Note what is there."""
        self._com.append(data.subtree_com[state_map.base_body].copy())
        base = data.model.body_dofadr[state_map.base_body]
        self._force.append(float(np.linalg.norm(data.qfrc_constraint[base : base + 3])))


class Until(Disturbance):
    """Another disturbance, but not for ever."""

    def __init__(self, end: float, disturbance: Disturbance) -> None:
        """Choose what ends when.

        Args:
            end: [s].
            disturbance: What ends.
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


def sweep(
    robot: Robot,
    controller: WholeBodyController,
    case: dict[str, Any],
    factors: Sequence[float],
    weights: list[float] | None = None,
    bisect: int = BISECTIONS,
) -> Outcome:
    """Stiffer and stiffer until it does not work, then halve the interval.

    Args:
        robot: The robot.
        controller: Its controller.
        case: Plain data of the case.
        factors: On P, rising.
        weights: Feedforward, (L,) [m/s^2].
        bisect: How often to halve, in the logarithm.

    Returns:
        One row per run, with 'factor', 'chatter' (RMS change of torque from tick
        to tick, as a share of its joint's limit, of the worst joint) and
        'stable': it neither fell nor needed safe torques.
    """
    outcome = Outcome()
    good, bad = 0.0, math.inf

    def works(factor: float) -> bool:
        run, _ = _run(robot, controller, Case.of(case), factor, weights, ())
        stable = not run.fell and not run.failures
        label = f"factor {factor:.4g}"
        more = {"factor": factor, "chatter": _chatter(run, robot), "stable": stable}
        outcome.rows.append({"label": label, **run.summary(), **more})
        return stable

    for factor in factors:
        if not works(factor):
            bad = factor
            break
        good = factor
    if good > 0.0 and math.isfinite(bad):
        for _ in range(bisect):
            middle = math.sqrt(good * bad)
            good, bad = (middle, bad) if works(middle) else (good, middle)
    return outcome


def disturb(
    robot: Robot,
    controller: WholeBodyController,
    case: dict[str, Any],
    factor: float,
    weights: list[float] | None,
    pushes: dict[str, list[float]],
    noise: float | None,
) -> Outcome:
    """The same run undisturbed, pushed and with torque noise.

    Args:
        robot: The robot.
        controller: Its controller.
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
        return _run(robot, controller, used, factor, weights, disturbances)

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


def _run(
    robot: Robot,
    controller: WholeBodyController,
    case: Case,
    factor: float,
    weights: list[float] | None,
    disturbances: Sequence[Disturbance],
) -> tuple[Run, Witness]:
    witness = Witness()
    run = case.simulator(robot).run(
        controller,
        case.motion,
        laps=case.laps,
        feedforward=None if weights is None else feedforward_of(case, robot, weights, "learned"),
        gains=case.gains,
        compensators=[Stiffness(factor)],
        disturbances=[*disturbances, witness],
        seed=case.seed,
    )
    return run, witness


def _loads(run: Run, witness: Witness, first: int, robot: Robot) -> dict[str, float]:
    """What ground and joints carry from a tick on."""
    torque = np.abs(run.log["tau"][first:]) / robot.torque_limit
    return {
        "peak_ground_force_n": float(witness.force[max(first, 1) :].max(initial=0.0)),
        "peak_torque_share": float(torque.max(initial=0.0)),
        "rms_torque_nm": float(np.sqrt(np.mean(run.log["tau"][first:].astype(float) ** 2))),
    }


def _response(deflection: Vector, impulse: Vector, fell: bool) -> dict[str, float | None]:
    """Peak and recovery along the push."""
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
    """None of a run that fell."""
    return float(np.sqrt(np.mean(values**2))) if values.size else None


def _chatter(run: Run, robot: Robot) -> float | None:
    torque = run.log["tau"][-round(1e3 * END) :] / robot.torque_limit
    if run.fell or len(torque) < 2:
        return None
    return float(np.sqrt(np.mean(np.diff(torque, axis=0) ** 2, axis=0)).max())
