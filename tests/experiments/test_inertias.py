from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from tsd_casadi import Controller, Robot, Squat, load_robot
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.identification.inertias import identify_inertias, identify_with_friction
from tsd_casadi.identification.observations import Observations
from tsd_casadi.identification.physical_consistency import pseudo_inertia
from tsd_casadi.identification.regressor import (
    free_motions,
    friction_rows,
    inertial_rows,
    nominal_parameters,
)
from tsd_clients import MujocoSimulator
from tsd_experiments.comparison.baselines.friction_feedforward import FrictionFeedforward
from tsd_experiments.comparison.baselines.motion_recorder import MotionRecorder, observe

SEED = 3


def contact_jacobian(robot: Robot, q: np.ndarray) -> np.ndarray:
    model, data = robot.model, robot.model.createData()
    return np.vstack(
        [
            pinocchio.computeFrameJacobian(
                model, data, q, model.getFrameId(contact.frame), pinocchio.LOCAL
            )
            for contact in robot.description.contacts
        ]
    )


def altered(robot: Robot) -> pinocchio.Model:
    """The robot with other masses, by up to a third, and shifted centres of mass."""
    rng = np.random.default_rng(SEED)
    model = robot.model.copy()
    for index in range(1, model.njoints):
        inertia = model.inertias[index]
        factor = rng.uniform(0.7, 1.3)
        lever = inertia.lever + rng.uniform(-0.01, 0.01, 3)
        model.inertias[index] = pinocchio.Inertia(
            factor * inertia.mass, lever, factor * inertia.inertia
        )
    return model


def synthetic(
    robot: Robot, model: pinocchio.Model, samples: int, viscous: float = 0.0, coulomb: float = 0.0
) -> Observations:
    """Motions of another model by RNEA, any contact wrenches, no noise."""
    rng = np.random.default_rng(SEED)
    data = model.createData()
    rows = []
    for _ in range(samples):
        q = pinocchio.integrate(model, robot.home.q, rng.uniform(-0.4, 0.4, model.nv))
        v, a = rng.normal(size=model.nv), 3 * rng.normal(size=model.nv)
        J = contact_jacobian(robot, q)
        generalized = pinocchio.rnea(model, data, q, v, a)
        # wrenches that carry the base, and others that press the feet together
        wrench = np.linalg.lstsq(J[:, :6].T, generalized[:6], rcond=None)[0]
        null = np.linalg.svd(J[:, :6].T)[2][6:]
        wrench += null.T @ rng.normal(scale=50, size=len(null))
        tau = generalized[6:] - J[:, 6:].T @ wrench
        tau += viscous * v[6:] + coulomb * np.sign(v[6:])
        rows.append((q, v, a, tau))
    return Observations(*(np.array(column) for column in zip(*rows, strict=True)))


def test_free_motions_keep_the_feet_still(robot: Robot) -> None:
    q = pinocchio.integrate(
        robot.model, robot.home.q, np.random.default_rng(0).uniform(-0.3, 0.3, robot.nv)
    )
    Z = free_motions(robot, q)
    assert Z.shape == (robot.nv, robot.nv - 12)
    assert np.abs(contact_jacobian(robot, q) @ Z).max() < 1e-9
    np.testing.assert_allclose(Z[6:].T @ Z[6:], np.eye(robot.nv - 12), atol=1e-9)


def test_rows_hold_for_the_true_parameters_and_any_wrench(robot: Robot) -> None:
    model = altered(robot)
    A, b = inertial_rows(robot, synthetic(robot, model, 10))
    pi = np.concatenate([inertia.toDynamicParameters() for inertia in list(model.inertias)[1:]])
    np.testing.assert_allclose(A @ pi, b, atol=1e-8)
    assert np.abs(A @ nominal_parameters(robot) - b).max() > 1.0


def test_friction_rows(robot: Robot) -> None:
    with_friction = synthetic(robot, robot.model, 10, viscous=0.7)
    without = synthetic(robot, robot.model, 10)
    _, b = inertial_rows(robot, with_friction)
    _, b0 = inertial_rows(robot, without)
    coefficients = np.concatenate((np.full(robot.n, 0.7), np.zeros(robot.n)))
    np.testing.assert_allclose(
        friction_rows(robot, with_friction) @ coefficients, b - b0, atol=1e-9
    )


def test_altered_masses_are_recovered(robot: Robot) -> None:
    """All that shows: unseen motions of the altered robot are explained."""
    model = altered(robot)
    found = identify_inertias(robot, synthetic(robot, model, 200), closeness=1e-6)
    assert found.residual < 1e-3
    assert found.nominal_residual > 1.0
    identified = robot.model.copy()
    for index, inertia in enumerate(found.inertias, start=1):
        identified.inertias[index] = inertia
    for seed in range(3):
        rng = np.random.default_rng(100 + seed)
        q = pinocchio.integrate(model, robot.home.q, rng.uniform(-0.4, 0.4, model.nv))
        v, a = rng.normal(size=model.nv), rng.normal(size=model.nv)
        Z = free_motions(robot, q)
        true, mine, nominal = (
            Z.T @ pinocchio.rnea(m, m.createData(), q, v, a)
            for m in (model, identified, robot.model)
        )
        assert np.abs(mine - true).max() < 1e-2 * np.abs(nominal - true).max()
    # the torso's mass shows on its own, as the pelvis turns against it
    torso = robot.model.getJointId("B_TFE")
    assert found.inertias[torso - 1].mass == pytest.approx(model.inertias[torso].mass, rel=0.02)


def test_friction_is_recovered(robot: Robot) -> None:
    observed = synthetic(robot, altered(robot), 200, viscous=0.7, coulomb=2.0)
    found = identify_with_friction(robot, observed, closeness=1e-6)
    np.testing.assert_allclose(found.friction.viscous, 0.7, atol=0.1)
    np.testing.assert_allclose(found.friction.coulomb, 2.0, atol=0.1)
    rigid = identify_inertias(robot, observed, closeness=1e-6)
    assert rigid.residual > 2 * found.residual
    assert not rigid.friction.viscous.any()


def test_noise_leaves_bodies_possible(robot: Robot) -> None:
    rng = np.random.default_rng(0)
    observed = synthetic(robot, robot.model, 5)
    noisy = Observations(
        observed.q, observed.v, observed.a, observed.tau + rng.normal(scale=300, size=(5, robot.n))
    )
    for inertia in identify_inertias(robot, noisy, closeness=1e-3).inertias:
        assert np.linalg.eigvalsh(pseudo_inertia(inertia.toDynamicParameters())).min() > 0


def test_refused(robot: Robot) -> None:
    observed = synthetic(robot, robot.model, 2)
    with pytest.raises(InvalidValue, match="closeness"):
        identify_inertias(robot, observed, closeness=0.0)
    broken = Observations(observed.q, observed.v, observed.a, np.full_like(observed.tau, np.nan))
    with pytest.raises(InvalidValue, match="tau"):
        identify_with_friction(robot, broken)


def test_observations_without_samples_or_of_another_robot_are_refused(robot: Robot) -> None:
    observed = synthetic(robot, robot.model, 2)
    with pytest.raises(InvalidValue, match=r"observed q.*shape"):
        identify_inertias(robot, Observations(*(part[:0] for part in vars(observed).values())))
    fewer = Observations(observed.q, observed.v, observed.a, observed.tau[:, :-1])
    with pytest.raises(InvalidValue, match=r"observed tau.*shape"):
        identify_inertias(robot, fewer)


def test_a_link_without_mass_is_named(write_robot: Callable[..., Path]) -> None:
    """Nothing is near to a body that cannot be."""

    def lighten(text: str) -> str:
        start = text.index('<link name="torso_yaw">')
        end = text.index("</link>", start)
        return text[:start] + '<link name="torso_yaw">' + text[end:]

    robot = load_robot(write_robot(urdf=lighten))
    with pytest.raises(InvalidValue, match=r"the link at .*mass 0 kg"):
        identify_inertias(robot, synthetic(robot, robot.model, 2))


def test_from_a_repetition(robot: Robot, controller: Controller) -> None:
    """The weight that the robot lifts is found from its own torques."""
    simulator = MujocoSimulator(robot, 0.1)
    recorder = MotionRecorder()
    run = simulator.run(controller, Squat(0.03, 1.0), compensators=[recorder])
    observed = observe(run, recorder)
    joints = observed.q[:, 7:]
    speed = np.gradient(joints, 1 / len(joints), axis=0)
    np.testing.assert_allclose(observed.v[5:-5, 6:], speed[5:-5], atol=0.02)
    acceleration = np.gradient(observed.v, 1 / len(joints), axis=0)
    scale = np.abs(observed.a).max()
    np.testing.assert_allclose(observed.a[5:-5], acceleration[5:-5], atol=0.01 * scale)
    found = identify_inertias(robot, observed)
    assert found.residual < found.nominal_residual / 10
    mass = sum(inertia.mass for inertia in found.inertias)
    nominal = robot.weight / 9.81
    # the feet, a tenth too heavy, carry no weight of their own
    assert mass == pytest.approx(nominal / 1.1, rel=0.015)


def test_friction_feedforward_asks_for_the_wanted_velocity(
    robot: Robot, controller: Controller
) -> None:
    """Mean power of friction's feedforward: viscous coefficient times squared speed."""
    found = identify_with_friction(robot, synthetic(robot, robot.model, 50, viscous=2.0))
    recorder, bare = MotionRecorder(), MotionRecorder()
    simulator = MujocoSimulator(robot)
    correction = FrictionFeedforward(found.friction)
    run = simulator.run(
        controller, Squat(0.03, 1.0), compensators=[bare, correction, recorder], laps=2
    )
    moving = run.log["lap"] >= 1
    added = (np.array(recorder.tau) - np.array(bare.tau))[moving]
    holding = (np.array(recorder.tau) - np.array(bare.tau))[run.log["lap"] < 0]
    assert np.abs(holding).max() < 1e-9
    expected = np.array([found.friction.torque(v[6:]) for v in np.array(recorder.v)[moving]])
    knee = robot.joint_names.index("L_KFE")
    assert np.corrcoef(added[:, knee], expected[:, knee])[0, 1] > 0.99
