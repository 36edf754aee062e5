from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio
import pytest

from tsd_casadi import Robot
from tsd_casadi.center_of_mass.mass_prior import MassPrior
from tsd_casadi.center_of_mass.prior_deviation import prior_deviation
from tsd_cli.actions.true_error import NOTICEABLE, tell_prior, tell_risen


@pytest.mark.parametrize("prior", [MassPrior(0.05, 0.0), MassPrior(0.0, 0.01), MassPrior(0.04)])
def test_the_deviation_is_that_of_robots_with_random_links(robot: Robot, prior: MassPrior) -> None:
    """By Pinocchio's own centre of mass of each of them."""
    rng, q = np.random.default_rng(0), robot.home.q
    coms = []
    for _ in range(1500):
        model = pinocchio.Model(robot.model)
        for link in range(1, len(model.inertias)):
            inertia = model.inertias[link]
            model.inertias[link] = pinocchio.Inertia(
                inertia.mass * (1 + prior.mass * rng.standard_normal()),
                inertia.lever + prior.center * rng.standard_normal(3),
                inertia.inertia,
            )
        coms.append(pinocchio.centerOfMass(model, model.createData(), q))
    # 1500 samples tell a deviation to 2 %
    np.testing.assert_allclose(np.std(coms, axis=0), prior_deviation(robot, q, prior), rtol=0.08)


def test_the_prior_is_told_with_its_size_where_a_centre_of_mass_is_learned(robot: Robot) -> None:
    (sentence,) = tell_prior(robot, ("torso.rz", "com.z"))
    assert "mass off by 10 % and its centre by 5 mm" in sentence
    assert "the true one at home is 15 mm away" in sentence
    assert "tsd calibrate" in sentence
    assert tell_prior(robot, ("torso.rz",)) == []


def summary(rms: float, true_rms: float | None, laps: int = 2) -> dict[str, Any]:
    errors = {
        "com.z": {"rms": rms, "true_rms": true_rms, "unit": "m"},
        "torso.rz": {"rms": 1.0, "true_rms": None, "unit": "rad"},
    }
    return {"errors": errors, "laps_measured": laps}


def test_a_true_error_that_rose_while_the_seen_one_fell_is_told() -> None:
    runs = [summary(8e-3, 8.9e-3), summary(1e-3, 9e-3), summary(1e-5, 11.8e-3), summary(1, 0, 0)]
    (sentence,) = tell_risen(runs)
    assert "com.z rose from 8.9 to 11.8 mm" in sentence
    assert "fell from 8 to 0.01 mm" in sentence


@pytest.mark.parametrize(
    "runs",
    [
        [],
        [summary(8e-3, 8.9e-3)],
        [summary(8e-3, 8.9e-3), summary(1e-5, 8.9e-3 * (1 + 0.99 * NOTICEABLE))],
        [summary(8e-3, 8.9e-3), summary(1e-5, 1e-5)],
        [summary(8e-3, None), summary(1e-5, None)],
        # nothing was learned: both rose
        [summary(8e-3, 8e-3), summary(9e-3, 9e-3)],
    ],
)
def test_nothing_is_told_of_what_did_not(runs: list[dict[str, Any]]) -> None:
    assert tell_risen(runs) == []
