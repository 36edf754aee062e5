"""How good a corrected centre of mass is, by the simulator's truth."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.center_of_mass.fit import StaticPose, fit_correction, prior_correction
from tsd_casadi.center_of_mass.mass_prior import MassPrior
from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.database.database import Database
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.center_of_mass_shift import CenterOfMassShift
from tsd_casadi.repetition.learn import learn
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.standing import stand, standing_heights
from tsd_casadi.state import Vector
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_clients.simulator.static_poses import true_center_of_mass, with_noise

# a force plate is better than this, sensors in the soles hardly are: less noise
# is not assumed by a fit, since joint angles and soles are not perfect either
LEAST_NOISE = 2e-4  # m


@dataclass(frozen=True)
class Accuracy:
    """How good the centre of mass is before and after a correction.

    Attributes:
        poses: How many were measured.
        cop_residual_before: RMS over poses and axes, measured centre of
            pressure against the model's centre of mass [m].
        cop_residual_after: Against the corrected one [m].
        error_before: RMS of the model's centre of mass over standing postures
            from the lowest to the highest, (3,) [m], by the simulator's truth.
        error_after: Of the corrected one, (3,) [m].
        deviation_before: Standard deviation at home by the prior, (3,) [m].
        deviation_after: By the fit, (3,) [m].
    """

    poses: int
    cop_residual_before: float
    cop_residual_after: float
    error_before: list[float]
    error_after: list[float]
    deviation_before: list[float]
    deviation_after: list[float]

    def plain(self) -> dict[str, Any]:
        """Write the accuracy as plain data for JSON."""
        return asdict(self)


def assess(
    simulator: MujocoSimulator,
    correction: CenterOfMassCorrection,
    poses: Sequence[StaticPose],
    prior: MassPrior | None = None,
) -> Accuracy:
    """Compare a correction with measurements and the simulator's truth.

    Args:
        poses: Measured, at least one.
    """
    robot = simulator.robot
    before = prior_correction(robot, float(np.mean([pose.weight for pose in poses])), prior)
    low, high = standing_heights(robot)
    standing = [stand(robot, height).q for height in (low, low / 2, 0.0, high / 2, high)]
    truths = [true_center_of_mass(simulator, q) for q in standing]
    seen = [robot.center_of_mass(pose.q)[:2] for pose in poses]
    corrected = [correction.center_of_mass(pose.q)[:2] for pose in poses]
    measured = [pose.center_of_pressure for pose in poses]
    return Accuracy(
        poses=len(poses),
        cop_residual_before=float(np.sqrt(np.mean(np.subtract(measured, seen) ** 2))),
        cop_residual_after=float(np.sqrt(np.mean(np.subtract(measured, corrected) ** 2))),
        error_before=_rms([robot.center_of_mass(q) for q in standing], truths),
        error_after=_rms([correction.center_of_mass(q) for q in standing], truths),
        deviation_before=before.deviation(robot.home.q).tolist(),
        deviation_after=correction.deviation(robot.home.q).tolist(),
    )


def by_poses_and_noise(
    simulator: MujocoSimulator,
    poses: Sequence[StaticPose],
    *,
    counts: Sequence[int] = (5, 10, 20, 40),
    noises: Sequence[float] = (2e-4, 5e-4, 1e-3, 2e-3),
    seeds: Sequence[int] = tuple(range(10)),
) -> list[dict[str, float]]:
    """Refit one collection with fewer poses and other noise.

    Args:
        poses: From ``collect``, without noise, the most telling first.
        counts: Numbers of poses; those beyond the collection are left out.
        noises: Standard deviations of the centre of pressure [m].

    Returns:
        One row for each count and noise: 'poses', 'noise_m', 'height_error_m'
        (RMS over seeds and standing postures), 'worst_height_error_m' (of one
        seed), 'deviation_m' (what the fit says itself) and 'model_error_m'.
    """
    rows = []
    for noise in noises:
        for count in (count for count in counts if count <= len(poses)):
            found = []
            for seed in seeds:
                noisy = with_noise(poses[:count], noise, seed=seed)
                fitted = fit_correction(simulator.robot, noisy, noise=max(noise, LEAST_NOISE))
                found.append(assess(simulator, fitted, noisy))
            heights = np.array([accuracy.error_after[2] for accuracy in found])
            rows.append(
                {
                    "poses": count,
                    "noise_m": noise,
                    "height_error_m": float(np.sqrt(np.mean(heights**2))),
                    "worst_height_error_m": float(heights.max()),
                    "deviation_m": found[0].deviation_after[2],
                    "model_error_m": found[0].error_before[2],
                }
            )
    return rows


def learn_with(
    simulator: MujocoSimulator,
    controller: WholeBodyController,
    motion: Motion,
    correction: CenterOfMassCorrection | None,
    *,
    iterations: int = 2,
    seed: int = 0,
) -> list[Run]:
    """Learn the axes that a motion moves from nothing, in a database of its own.

    By the paper's rule.

    Args:
        correction: Of the centre of mass; None goes on with the model's.

    Returns:
        The runs, one more than iterations; ``true_rms`` of their errors is the
        measure, ``rms`` what the controller sees.
    """
    compensators = [] if correction is None else [CenterOfMassShift(correction)]
    with tempfile.TemporaryDirectory() as folder, Database(Path(folder) / "study") as database:
        return learn(
            simulator,
            controller,
            [motion],
            database,
            axes=motion.axes(simulator.robot),
            iterations=iterations,
            rule="plain",
            compensators=compensators,
            seed=seed,
        )


def _rms(found: list[Vector], truths: list[Vector]) -> list[float]:
    squares: Vector = np.mean(np.subtract(found, truths) ** 2, axis=0)
    return [float(root) for root in np.sqrt(squares)]
