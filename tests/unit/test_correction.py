from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Robot, load_robot
from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.center_of_mass.fit import (
    StaticPose,
    fit_correction,
    prior_correction,
)
from tsd_casadi.center_of_mass.mass_prior import MassPrior
from tsd_casadi.center_of_mass.static_chain import StaticChain
from tsd_casadi.exceptions import InvalidValue, MalformedMessage
from tsd_casadi.state import Vector

seeds = st.integers(0, 10_000)


def random_q(robot: Robot, rng: np.random.Generator, spread: float = 0.5) -> Vector:
    step = spread * rng.standard_normal(robot.nv)
    return np.asarray(pinocchio.integrate(robot.model, robot.home.q, step))


def altered(robot: Robot, seed: int) -> Any:
    """The robot's model with masses and centres of mass of its own."""
    rng = np.random.default_rng(seed)
    model = pinocchio.Model(robot.model)
    for index in range(1, model.njoints):
        inertia = model.inertias[index]
        mass = inertia.mass * (1 + 0.2 * rng.uniform(-1, 1))
        center = inertia.lever + 0.01 * rng.uniform(-1, 1, size=3)
        model.inertias[index] = pinocchio.Inertia(mass, center, inertia.inertia)
    return model


def com_of(model: Any, q: Vector) -> Vector:
    return np.array(pinocchio.centerOfMass(model, model.createData(), q))


def pose_of(model: Any, q: Vector) -> StaticPose:
    weight = 9.81 * pinocchio.computeTotalMass(model)
    return StaticPose(q, com_of(model, q)[:2], weight)


@pytest.fixture(scope="module")
def correction(robot: Robot) -> CenterOfMassCorrection:
    rng = np.random.default_rng(1)
    truth = altered(robot, 3)
    poses = [pose_of(truth, random_q(robot, rng, 0.2)) for _ in range(20)]
    return fit_correction(robot, poses)


@given(seeds)
def test_the_chain_is_pinocchios_centre_of_mass(robot: Robot, seed: int) -> None:
    q = random_q(robot, np.random.default_rng(seed))
    chain = StaticChain(robot)
    tip = q[:3] + chain.features(q) @ chain.terms().ravel()
    np.testing.assert_allclose(tip, com_of(robot.model, q), atol=1e-12)


@given(seeds)
def test_a_correction_follows_its_vectors(robot: Robot, seed: int) -> None:
    rng = np.random.default_rng(seed)
    chain, q = StaticChain(robot), random_q(robot, rng)
    terms = 0.1 * rng.standard_normal((len(chain.links), 3))
    corrected = CenterOfMassCorrection(robot, terms, np.zeros((terms.size, terms.size)))
    expected = q[:3] + sum(
        R @ r for R, r in zip(np.hsplit(chain.features(q), len(terms)), terms, strict=True)
    )
    np.testing.assert_allclose(corrected.center_of_mass(q), expected, atol=1e-12)
    offset = expected - com_of(robot.model, q)
    np.testing.assert_allclose(corrected.offset(q), offset, atol=1e-12)


def test_enough_poses_without_noise_recover_another_robots_centre_of_mass(robot: Robot) -> None:
    rng = np.random.default_rng(0)
    truth = altered(robot, 7)
    poses = [pose_of(truth, random_q(robot, rng)) for _ in range(60)]
    fitted = fit_correction(robot, poses, noise=1e-8)
    for _ in range(20):
        q = random_q(robot, rng)
        np.testing.assert_allclose(fitted.center_of_mass(q), com_of(truth, q), atol=1e-6)
    # it was worth while
    assert np.abs(fitted.offset(robot.home.q)).max() > 1e-3


def test_poses_of_the_models_own_robot_change_nothing(robot: Robot) -> None:
    rng = np.random.default_rng(0)
    poses = [pose_of(robot.model, random_q(robot, rng, 0.2)) for _ in range(5)]
    fitted = fit_correction(robot, poses)
    np.testing.assert_allclose(fitted.terms, StaticChain(robot).terms(), atol=1e-12)


@given(seeds)
def test_one_pose_says_nothing_about_height(robot: Robot, seed: int) -> None:
    # exactly nothing only where the links' centres alone may be off: an error of
    # a mass shifts the height and, where the link leans, the centre of pressure
    prior = MassPrior(mass=0.0, center=0.01)
    q = random_q(robot, np.random.default_rng(seed))
    pose = pose_of(altered(robot, seed), q)
    before = prior_correction(robot, pose.weight, prior)
    after = fit_correction(robot, [pose], prior=prior)
    assert after.deviation(q)[2] == pytest.approx(before.deviation(q)[2], rel=1e-9)
    assert after.center_of_mass(q)[2] == pytest.approx(before.center_of_mass(q)[2], abs=1e-9)
    assert (after.deviation(q)[:2] < 0.5 * before.deviation(q)[:2]).all()


def test_the_prior_is_that_of_random_masses_of_known_sum(robot: Robot) -> None:
    chain = StaticChain(robot)
    rng = np.random.default_rng(5)
    prior = MassPrior(0.05, 0.005)
    weight = 1.02 * robot.weight
    total = 1.02 * chain.masses.sum()
    # by rejection instead of the conditional's formula
    masses = chain.masses * (1 + prior.mass * rng.standard_normal((400_000, len(chain.masses))))
    masses = masses[np.abs(masses.sum(axis=1) - total) < 0.005 * total]
    assert len(masses) > 5000
    terms = masses @ chain.moments().T / total
    spread = prior.center * np.repeat(chain.masses, 3) / total
    terms += spread * rng.standard_normal(terms.shape)
    heights = terms @ chain.features(robot.home.q)[2] + robot.home.q[2]
    known = prior_correction(robot, weight, prior)
    assert known.center_of_mass(robot.home.q)[2] == pytest.approx(heights.mean(), abs=3e-4)
    assert known.deviation(robot.home.q)[2] == pytest.approx(heights.std(), rel=0.05)


def test_errors_are_as_large_as_the_fit_says(robot: Robot) -> None:
    rng = np.random.default_rng(2)
    noise, ratios = 1e-3, []
    chain = StaticChain(robot)
    known = prior_correction(robot)
    values, vectors = np.linalg.eigh(known.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    poses = [random_q(robot, rng, 0.15) for _ in range(15)]
    F = [chain.features(q)[:2] for q in poses]
    target = chain.features(robot.home.q)[2]
    for _ in range(60):
        truth = known.terms.ravel() + root @ rng.standard_normal(len(root))
        measured = [
            StaticPose(q, q[:2] + f @ truth + noise * rng.standard_normal(2), robot.weight)
            for q, f in zip(poses, F, strict=True)
        ]
        fitted = fit_correction(robot, measured, noise=noise)
        error = target @ (fitted.terms.ravel() - truth)
        ratios.append(error / fitted.deviation(robot.home.q)[2])
    assert 0.75 < np.sqrt(np.mean(np.square(ratios))) < 1.3


def test_more_poses_make_the_height_surer(robot: Robot) -> None:
    rng = np.random.default_rng(4)
    poses = [pose_of(robot.model, random_q(robot, rng, 0.2)) for _ in range(12)]
    deviations = [
        fit_correction(robot, poses[:count]).deviation(robot.home.q)[2] for count in (1, 4, 12)
    ]
    prior = prior_correction(robot).deviation(robot.home.q)[2]
    assert prior > deviations[0] > deviations[1] > 1.5 * deviations[2] > 0


@given(seeds)
def test_the_offsets_rate_is_its_derivative(
    robot: Robot, correction: CenterOfMassCorrection, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    q, v, dt = random_q(robot, rng), rng.standard_normal(robot.nv), 1e-5
    ahead, behind = (pinocchio.integrate(robot.model, q, sign * dt * v) for sign in (1, -1))
    difference = (correction.offset(ahead) - correction.offset(behind)) / (2 * dt)
    np.testing.assert_allclose(correction.offset_rate(q, v), difference, atol=1e-8)


def test_a_file_gives_the_same_correction(
    robot: Robot, correction: CenterOfMassCorrection, tmp_path: Path
) -> None:
    correction.save(tmp_path / "com.json")
    again = CenterOfMassCorrection.load(robot, tmp_path / "com.json")
    np.testing.assert_array_equal(again.terms, correction.terms)
    np.testing.assert_array_equal(again.covariance, correction.covariance)


def _negative_variance(document: Any) -> None:
    document["covariance"][0][0] = -1.0


@pytest.mark.parametrize(
    ("edit", "error", "words"),
    [
        (lambda d: d.update(robot="another"), InvalidValue, "another"),
        (lambda d: d.update(fingerprint="0" * 16), InvalidValue, "tsd calibrate"),
        (lambda d: d["links"].reverse(), InvalidValue, "links"),
        (lambda d: d.update(extra=1), MalformedMessage, "extra"),
        (lambda d: d.pop("terms"), MalformedMessage, "terms"),
        (lambda d: d["terms"].pop(), MalformedMessage, "terms of another shape"),
        (lambda d: d["covariance"][2].pop(), MalformedMessage, "covariance of another shape"),
        (_negative_variance, InvalidValue, "covariance"),
    ],
)
def test_a_wrong_file_is_refused(
    robot: Robot,
    correction: CenterOfMassCorrection,
    tmp_path: Path,
    edit: Callable[[Any], object],
    error: type[Exception],
    words: str,
) -> None:
    document = json.loads(correction.message().encode())
    edit(document)
    path = tmp_path / "com.json"
    path.write_text(json.dumps(document))
    with pytest.raises(error, match=words):
        CenterOfMassCorrection.load(robot, path)


@pytest.mark.parametrize("content", [None, b"", b"\xff", b"[]", b"NaN"])
def test_what_is_no_correction_is_refused(
    robot: Robot, tmp_path: Path, content: bytes | None
) -> None:
    path = tmp_path / "com.json"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(MalformedMessage, match=r"com\.json.*tsd calibrate"):
        CenterOfMassCorrection.load(robot, path)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"q": np.zeros(3)}, r"poses\[0\]\.q"),
        ({"center_of_pressure": np.array([np.nan, 0.0])}, "center_of_pressure"),
        ({"center_of_pressure": np.zeros(3)}, "center_of_pressure"),
        ({"weight": -1.0}, "weight"),
        ({"weight": np.inf}, "weight"),
    ],
)
def test_a_pose_that_is_none_is_refused(robot: Robot, change: dict[str, Any], field: str) -> None:
    pose = StaticPose(**{**vars(pose_of(robot.model, robot.home.q)), **change})
    with pytest.raises(InvalidValue, match=field):
        fit_correction(robot, [pose])


def test_nothing_to_fit_is_refused(robot: Robot) -> None:
    pose = pose_of(robot.model, robot.home.q)
    with pytest.raises(InvalidValue, match="poses"):
        fit_correction(robot, [])
    for noise in (0.0, -1.0, np.nan):
        with pytest.raises(InvalidValue, match="noise"):
            fit_correction(robot, [pose], noise=noise)
    for values in ((0.0, 0.0), (-0.1, 0.0), (np.nan, 0.1), (0.1, 2.0)):
        with pytest.raises(InvalidValue, match="prior"):
            MassPrior(*values)


def test_a_prismatic_joint_has_no_chain(write_robot: Callable[..., Path]) -> None:
    def slide(urdf: str) -> str:
        start = urdf.index('<joint name="B_TR"')
        return urdf[:start] + urdf[start:].replace('type="revolute"', 'type="prismatic"', 1)

    robot = load_robot(write_robot(urdf=slide))
    with pytest.raises(InvalidValue, match=r"B_TR.*revolute"):
        StaticChain(robot)
