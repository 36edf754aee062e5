from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tsd_casadi import Controller, Robot, State
from tsd_casadi.center_of_mass.fit import StaticPose, fit_correction
from tsd_casadi.center_of_mass.pose_design import design_poses
from tsd_casadi.exceptions import InvalidValue, SimulationError
from tsd_clients import ModelError, MujocoSimulator
from tsd_clients.simulator.mujoco_plant import MujocoPlant
from tsd_clients.simulator.static_poses import collect, true_center_of_mass, with_noise
from tsd_experiments.beyond.true_center_of_mass.study import assess, by_poses_and_noise

COUNT = 6


@pytest.fixture(scope="module")
def simulator(robot: Robot) -> MujocoSimulator:
    return MujocoSimulator(robot, ModelError(per_link=0.1, seed=1))


@pytest.fixture(scope="module")
def poses(simulator: MujocoSimulator, controller: Controller) -> list[StaticPose]:
    return collect(simulator, controller, count=COUNT)


def test_at_rest_the_centre_of_pressure_is_below_the_true_centre_of_mass(
    simulator: MujocoSimulator, poses: list[StaticPose]
) -> None:
    for pose in poses:
        com = true_center_of_mass(simulator, pose.q)
        np.testing.assert_allclose(pose.center_of_pressure, com[:2], atol=2e-4)
        # which is not where the model has it
    seen = [simulator.robot.center_of_mass(pose.q)[:2] for pose in poses]
    measured = [pose.center_of_pressure for pose in poses]
    assert np.abs(np.subtract(seen, measured)).max() > 2e-3


def test_the_ground_carries_the_true_weight(
    simulator: MujocoSimulator, poses: list[StaticPose]
) -> None:
    weight = 9.81 * simulator.model.body_mass.sum()
    assert abs(weight - simulator.robot.weight) > 5.0
    for pose in poses:
        assert pose.weight == pytest.approx(weight, rel=1e-3)


def test_the_true_centre_of_mass_is_the_mean_of_the_bodies(simulator: MujocoSimulator) -> None:
    q = design_poses(simulator.robot, 1)[0].q
    data = mujoco.MjData(simulator.model)
    simulator.state_map.write(data, State(q, np.zeros(simulator.robot.nv)))
    mujoco.mj_forward(simulator.model, data)
    mean = simulator.model.body_mass @ data.xipos / simulator.model.body_mass.sum()
    np.testing.assert_allclose(true_center_of_mass(simulator, q), mean, atol=1e-12)


def test_ground_force_is_newtons_second_law(
    simulator: MujocoSimulator, controller: Controller, robot: Robot
) -> None:
    # under way, where it is neither the weight nor below the centre of mass
    plant = MujocoPlant(robot, simulator.model, robot.home, robot.home, (), (), 0)
    command = controller.command()
    command["com.reference"] = robot.home_com + np.array([0.03, 0.02, -0.05])
    coms, forces, centers = [], [], []
    for tick in range(300):
        _, state = plant.measure()
        coms.append(plant.com.copy())
        plant.step(controller.tick(state, command).tau, tick * simulator.period)
        force, center = plant.ground_force()
        forces.append(force)
        centers.append(center)
    acceleration = np.diff(coms, n=2, axis=0) / simulator.period**2
    expected = simulator.model.body_mass.sum() * (acceleration - simulator.model.opt.gravity)
    np.testing.assert_allclose(np.array(forces)[50:-2], expected[50:], atol=2.0)
    assert np.abs(acceleration[50:]).max() > 0.3
    assert np.abs(np.array(centers)[50:] - np.array(coms)[50:, :2]).max() > 0.01


def test_in_the_air_there_is_no_centre_of_pressure(
    simulator: MujocoSimulator, robot: Robot
) -> None:
    q = robot.home.q.copy()
    q[2] += 0.1
    plant = MujocoPlant(robot, simulator.model, State(q, robot.home.v), robot.home, (), (), 0)
    plant.measure()
    plant.step(np.zeros(robot.n), 0.0)
    force, center = plant.ground_force()
    assert not force.any()
    assert np.isnan(center).all()


def test_poses_stand_within_soles_and_limits(robot: Robot) -> None:
    postures = design_poses(robot, 40)
    soles = robot.sole_placements(robot.home.q)
    shifts = []
    for posture in postures:
        for sole, expected in zip(robot.sole_placements(posture.q), soles, strict=True):
            np.testing.assert_allclose(sole.homogeneous, expected.homogeneous, atol=1e-5)
        assert (posture.q[7:] > robot.model.lowerPositionLimit[7:]).all()
        assert (posture.q[7:] < robot.model.upperPositionLimit[7:]).all()
        shifts.append(robot.center_of_mass(posture.q) - robot.home_com)
    assert np.abs(shifts)[:, 0].max() <= 0.05 + 1e-5
    assert np.abs(shifts)[:, 1].max() <= 0.08
    assert np.ptp(shifts, axis=0).min() > 0.08


def test_designed_poses_beat_random_ones_and_the_first_ones_are_best(robot: Robot) -> None:
    def deviation(postures: list[State]) -> float:
        measured = [StaticPose(p.q, robot.center_of_mass(p.q)[:2], robot.weight) for p in postures]
        return float(fit_correction(robot, measured).deviation(robot.home.q)[2])

    postures = design_poses(robot, 100)
    first, last = deviation(postures[:10]), deviation(postures[-10:])
    assert first < 0.8 * last
    assert deviation(design_poses(robot, 10)) < 1.2 * first


def test_the_height_comes_out_right(simulator: MujocoSimulator, poses: list[StaticPose]) -> None:
    rows = by_poses_and_noise(simulator, poses, counts=(2, COUNT, 100), noises=(5e-4,))
    assert [row["poses"] for row in rows] == [2, COUNT]
    assert rows[-1]["height_error_m"] < 0.5 * rows[-1]["model_error_m"]
    assert rows[-1]["height_error_m"] < 2 * rows[-1]["deviation_m"]
    accuracy = assess(simulator, fit_correction(simulator.robot, poses), poses)
    assert accuracy.cop_residual_after < 0.2 * accuracy.cop_residual_before


def test_noise_has_the_standard_deviation_asked_for(poses: list[StaticPose]) -> None:
    many = poses * 200
    noisy = with_noise(many, 1e-3, seed=3)
    added = [n.center_of_pressure - p.center_of_pressure for n, p in zip(noisy, many, strict=True)]
    np.testing.assert_allclose(np.std(added, axis=0), 1e-3, rtol=0.1)
    again = with_noise(many, 1e-3, seed=3)
    np.testing.assert_array_equal(again[5].center_of_pressure, noisy[5].center_of_pressure)
    assert noisy[0].q is many[0].q


def test_hardware_effects_count_and_an_inclinometer_makes_up_for_soft_ground(
    robot: Robot, controller: Controller
) -> None:
    simulator = MujocoSimulator(robot, hardware=["all"])
    calls: list[tuple[float, float]] = []
    errors = {}
    for inclinometer in (None, 0.0):
        poses = collect(
            simulator,
            controller,
            count=3,
            inclinometer=inclinometer,
            progress=lambda *call: calls.append(call),
        )
        differences = [p.center_of_pressure - robot.center_of_mass(p.q)[:2] for p in poses]
        errors[inclinometer] = np.abs(differences).max()
    assert calls == 2 * [(1, 3), (2, 3), (3, 3)]
    # four seeds: 0.25 to 0.49 mm without, 0.48 to 0.53 times that with one
    assert errors[0.0] < 0.7 * errors[None]
    assert 1e-4 < errors[None] < 1e-3


@pytest.mark.parametrize("count", [0, -1, 501])
def test_impossible_numbers_of_poses_are_refused(
    simulator: MujocoSimulator, controller: Controller, count: int
) -> None:
    with pytest.raises(InvalidValue, match="poses"):
        collect(simulator, controller, count=count)


def test_a_robot_that_cannot_stand_is_reported(robot: Robot, controller: Controller) -> None:
    hopeless = MujocoSimulator(robot, ModelError(uniform=-0.9))
    with pytest.raises(SimulationError, match="model error"):
        collect(hopeless, controller, count=2)
