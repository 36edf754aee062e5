from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tsd_casadi import Controller, Database, Robot, Squat, learn, load_robot
from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.center_of_mass.fit import StaticPose, fit_correction, prior_correction
from tsd_casadi.center_of_mass.pose_design import design_poses
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.center_of_mass_shift import CenterOfMassShift
from tsd_clients import ModelError, MujocoSimulator
from tsd_clients.simulator.static_poses import true_center_of_mass, with_noise

SQUAT = Squat(0.02, 1.0)


@pytest.fixture(scope="module")
def simulator(robot: Robot) -> MujocoSimulator:
    return MujocoSimulator(robot, ModelError(per_link=0.1, seed=1))


@pytest.fixture(scope="module")
def correction(simulator: MujocoSimulator) -> CenterOfMassCorrection:
    # by statics, without the simulation's minute of standing
    robot = simulator.robot
    weight = 9.81 * float(simulator.model.body_mass.sum())
    poses = [
        StaticPose(posture.q, true_center_of_mass(simulator, posture.q)[:2], weight)
        for posture in design_poses(robot, 20)
    ]
    return fit_correction(robot, with_noise(poses, 5e-4))


def test_learning_takes_away_the_true_error(
    simulator: MujocoSimulator,
    controller: Controller,
    correction: CenterOfMassCorrection,
    tmp_path: Path,
) -> None:
    errors = {}
    for name, compensators in (("without", []), ("with", [CenterOfMassShift(correction)])):
        with Database(tmp_path / f"{name}.sqlite") as database:
            runs = learn(
                simulator,
                controller,
                [SQUAT],
                database,
                axes=("com.z",),
                laps=2,
                compensators=compensators,
            )
        errors[name] = runs[-1].errors["com.z"].true_rms
        # what the controller sees is small either way
        first, last = (runs[index].errors["com.z"].rms for index in (0, -1))
        assert last < 0.1 * first
    assert errors["without"] > 5e-3
    assert errors["with"] < 0.2 * errors["without"]


def test_the_controllers_error_is_that_of_the_corrected_centre_of_mass(
    simulator: MujocoSimulator,
    controller: Controller,
    correction: CenterOfMassCorrection,
    robot: Robot,
) -> None:
    run = simulator.run(controller, SQUAT, laps=2, compensators=[CenterOfMassShift(correction)])
    assert run.axes == ("com.z", "com.x", "com.y")
    for tick in range(0, run.ticks, 300):
        com = correction.center_of_mass(run.log["q"][tick].astype(float))[[2, 0, 1]]
        expected = run.log["reference"][tick] + robot.home_com[[2, 0, 1]] - com
        np.testing.assert_allclose(run.log["error"][tick], expected, atol=1e-6)
    # and the feedback's rate that of its error
    error = run.along("error", "com.z")
    feedback = run.gains["P"][0] * error + run.gains["D"][0] * np.gradient(error, 1e-3)
    late = slice(1500, run.ticks - 1)
    found = run.along("feedback", "com.z")
    np.testing.assert_allclose(found[late], feedback[late], atol=0.01)


def test_a_correction_that_knows_nothing_changes_nothing(
    simulator: MujocoSimulator, controller: Controller, robot: Robot
) -> None:
    nothing = prior_correction(robot)
    plain = simulator.run(controller, SQUAT, laps=2)
    shifted = simulator.run(controller, SQUAT, laps=2, compensators=[CenterOfMassShift(nothing)])
    for axis, error in plain.errors.items():
        assert shifted.errors[axis].true_rms == pytest.approx(error.true_rms, abs=1e-8)


def test_another_models_correction_is_refused(
    simulator: MujocoSimulator, controller: Controller, write_robot: Callable[..., Path]
) -> None:
    changed = load_robot(write_robot(lambda document: document["posture"].update(P=41.0)))
    shift = CenterOfMassShift(prior_correction(changed))
    with pytest.raises(InvalidValue, match="correction"):
        simulator.run(controller, SQUAT, compensators=[shift])
