"""One simulated setting as plain data, and the runs made in it."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.database.database import Database
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.feedforward import Feedforward, Kind
from tsd_casadi.learning.recording import Rule
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.learn import Learner, learn
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_clients.simulator.disturbances import Disturbance
from tsd_clients.simulator.model_error import ModelError
from tsd_clients.simulator.simulator import MujocoSimulator

# ticks between two samples of a stored trace
TRACE_STEP = 10
TRACES = ("time", "phase", "lap", "reference", "error", "true_error", "feedback", "feedforward")


@dataclass(frozen=True)
class Case:
    """A robot, a motion and gains.

    Attributes:
        amplitude: [m].
        frequency: [Hz].
        height: Middle of the motion above home [m].
        model_error: E of every link.
        link_error: Further error with random sign on each link.
        link_seed: Of the signs.
        hardware: Hardware effects that count.
        p_scale: Factor on P.
        d_scale: Factor on D.
        laps: Least number of laps.
        seed: Of starting posture and sensor noise.
    """

    amplitude: float = 0.03
    frequency: float = 0.25
    height: float = 0.0
    model_error: float = 0.1
    link_error: float = 0.0
    link_seed: int = 0
    hardware: tuple[str, ...] = ()
    p_scale: float = 1.0
    d_scale: float = 1.0
    laps: int = 3
    seed: int = 0

    @property
    def motion(self) -> Squat:
        """The motion."""
        return Squat(self.amplitude, self.frequency, self.height)

    @property
    def gains(self) -> Gains:
        """The factors on the gains."""
        return Gains(self.p_scale, self.d_scale)

    def at_stiffness(self, factor: float) -> Case:
        """The same with P times a factor and the damping ratio kept."""
        gains = Gains.critical(factor)
        return replace(self, p_scale=gains.P, d_scale=gains.D)

    def simulator(self, robot: Robot) -> MujocoSimulator:
        """The simulated robot."""
        error = ModelError(self.model_error, self.link_error, self.link_seed)
        return MujocoSimulator(robot, error, self.hardware)

    def plain(self) -> dict[str, Any]:
        """Plain data; ``Case(**plain)`` is the same case."""
        return {**asdict(self), "hardware": list(self.hardware)}

    @classmethod
    def of(cls, plain: dict[str, Any]) -> Case:
        """From plain data."""
        return cls(**{**plain, "hardware": tuple(plain["hardware"])})


@dataclass
class Outcome:
    """What a job leaves behind.

    Attributes:
        rows: One per run, plain data for JSON.
        arrays: Named arrays for the npz.
    """

    rows: list[dict[str, Any]] = field(default_factory=list)
    arrays: dict[str, Vector] = field(default_factory=dict)

    def add(self, label: str, run: Run, **more: Any) -> None:
        """Keep a run: its measures, its trace and its weights.

        Args:
            label: Name of the run, unique in the outcome.
            run: The run.
            more: Further plain data for its row.
        """
        self.rows.append({"label": label, **run.summary(), **more})
        for name in TRACES:
            self.arrays[f"{label}/{name}"] = run.log[name][::TRACE_STEP].astype(np.float32)
        self.arrays[f"{label}/weights"] = run.feedforward.weights


def learn_case(
    case: Case,
    robot: Robot,
    controller: WholeBodyController,
    *,
    rule: Rule,
    iterations: int,
    first: Sequence[float] | None = None,
    seeds: Sequence[int] | None = None,
    learner: Learner | None = None,
    compensators: Sequence[Compensator] = (),
    transport: str = "local",
) -> Outcome:
    """Learn one case from nothing, or from given weights.

    Args:
        case: The case.
        robot: The robot.
        controller: Its controller.
        rule: The learning rule.
        iterations: N; there are N + 1 runs.
        first: Weights to start from, (L,) [m/s^2].
        seeds: One for each of the N + 1 runs; the case's for all by default.
        learner: Where to record; a database that is thrown away by default.
        compensators: What else changes commands and torques.
        transport: How the controller is reached.

    Returns:
        Rows labelled 'iteration 0' ... The last row has 'stopped' if the robot
        fell or never settled. With a database of its own, by harmonic: what the
        filter of each iteration predicted at most and what the plain sum would
        leave, 'filter/predicted' and 'filter/plain', (N, harmonics), and what
        was left, 'filter/observed'; NaN where nothing could be told.
    """
    if learner is None:
        with tempfile.TemporaryDirectory() as folder, Database(Path(folder) / "case") as database:
            return learn_case(
                case,
                robot,
                controller,
                rule=rule,
                iterations=iterations,
                first=first,
                seeds=seeds,
                learner=database,
                compensators=compensators,
                transport=transport,
            )
    from tsd_casadi.exceptions import SimulationError

    outcome = Outcome()
    filters: list[Contraction] = []

    def keep(run: Run, notes: list[str]) -> None:
        label = f"iteration {len(outcome.rows)}"
        outcome.add(label, run, notes=notes, served=run.feedforward.iteration)
        if isinstance(learner, Database):
            # of the iteration that is learned from this run
            filters.extend(learner.entries()[0].contractions[:1])
        if label == "iteration 0" and run.laps:
            # one whole lap, for the encoding error
            outcome.arrays["lap/phase"] = run.laps[0].phase
            outcome.arrays["lap/feedback"] = run.laps[0].feedback

    try:
        learn(
            case.simulator(robot),
            controller,
            [case.motion],
            learner,
            iterations=iterations,
            restart=True,
            rule=rule,
            laps=case.laps,
            gains=case.gains,
            first=None if first is None else feedforward_of(case, robot, first, "nearest"),
            compensators=compensators,
            seed=case.seed if seeds is None else seeds,
            transport=transport,
            on_run=keep,
        )
    except SimulationError as error:
        outcome.rows.append({"label": "stopped", "stopped": str(error)})
    if isinstance(learner, Database) and filters:
        for name in ("predicted", "plain"):
            rows = [getattr(each, name) for each in filters]
            outcome.arrays[f"filter/{name}"] = np.array(rows, dtype=float)  # None is NaN
        observed = learner.entries()[0].observed_contractions()
        if observed is not None:
            outcome.arrays["filter/observed"] = observed
    return outcome


def replay_case(
    case: Case,
    robot: Robot,
    controller: WholeBodyController,
    *,
    weights: Sequence[float] | None,
    kind: Kind = "learned",
    label: str = "replay",
    compensators: Sequence[Compensator] = (),
    disturbances: Sequence[Disturbance] = (),
    transport: str = "local",
) -> Outcome:
    """One run with given weights and no learning.

    Args:
        case: The case.
        robot: The robot.
        controller: Its controller.
        weights: (L,) [m/s^2]; None for no feedforward.
        kind: Where the weights come from; 'constant' uses their mean only.
        label: Name of the run.
        compensators: What else changes commands and torques.
        disturbances: What pushes the robot.
        transport: How the controller is reached.

    Returns:
        One row.
    """
    feedforward = None if weights is None else feedforward_of(case, robot, weights, kind)
    if feedforward is not None and kind == "constant":
        feedforward = feedforward.constant()
    run = case.simulator(robot).run(
        controller,
        case.motion,
        laps=case.laps,
        feedforward=feedforward,
        gains=case.gains,
        compensators=compensators,
        disturbances=disturbances,
        seed=case.seed,
        transport=transport,
    )
    outcome = Outcome()
    outcome.add(label, run)
    return outcome


def feedforward_of(case: Case, robot: Robot, weights: Sequence[float], kind: Kind) -> Feedforward:
    """A feedforward from bare weights.

    Args:
        case: What it is for.
        robot: The robot.
        weights: (L,) [m/s^2].
        kind: Where they come from.
    """
    motion = case.motion
    matrix = np.asarray(weights, dtype=float)[None, :]
    return Feedforward(
        axes=(f"{motion.task(robot)}.{motion.axis}",),
        basis=PeriodicBasis.of_size(matrix.shape[1]),
        weights=matrix,
        standard_deviations=np.zeros_like(matrix),
        kind=kind,
        parameters=motion.parameters,
    )
