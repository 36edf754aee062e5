from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio
import pytest

from pinocchio_casadi import SymbolicModel, UnsupportedJoint
from tsd_casadi import Robot, load_robot

STATES = 20
TOLERANCE = 1e-10
# every joint type of the collection but the free flyer
JOINTS = (
    pinocchio.JointModelRX,
    pinocchio.JointModelRY,
    pinocchio.JointModelRZ,
    lambda: pinocchio.JointModelRevoluteUnaligned(*unit((1.0, -2.0, 0.5))),
    pinocchio.JointModelPX,
    pinocchio.JointModelPY,
    pinocchio.JointModelPZ,
    lambda: pinocchio.JointModelPrismaticUnaligned(*unit((0.3, 0.4, -1.0))),
)


def unit(x: tuple[float, float, float]) -> tuple[float, ...]:
    return tuple(np.array(x) / np.linalg.norm(x))


def every_joint_type() -> Any:
    pinocchio.seed(3)
    model = pinocchio.Model()
    model.gravity.linear = np.array([0.5, -1.0, -9.0])
    trunk = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Random(), "base")
    model.appendBodyToJoint(trunk, pinocchio.Inertia.Random(), pinocchio.SE3.Identity())
    for branch in range(2):
        parent = trunk
        for index, joint in enumerate(JOINTS[branch::2]):
            placement = pinocchio.SE3.Random()
            parent = model.addJoint(parent, joint(), placement, f"joint_{branch}_{index}")
            model.appendBodyToJoint(parent, pinocchio.Inertia.Random(), pinocchio.SE3.Random())
        model.addFrame(
            pinocchio.Frame(
                f"tip_{branch}", parent, 0, pinocchio.SE3.Random(), pinocchio.FrameType.OP_FRAME
            )
        )
    model.addFrame(
        pinocchio.Frame("ground", 0, 0, pinocchio.SE3.Random(), pinocchio.FrameType.OP_FRAME)
    )
    model.armature = np.linspace(0.1, 2.0, model.nv)
    return model


def shipped_robot() -> Any:
    return load_robot("hermes_lower").model


MODELS = {
    "shipped": (shipped_robot, ("L_sole", "torso", "R_KFE")),
    "humanoid": (pinocchio.buildSampleModelHumanoid, None),
    "every joint type": (every_joint_type, ("tip_0", "tip_1", "ground")),
}


@pytest.fixture(scope="module", params=MODELS)
def model(request: pytest.FixtureRequest) -> Any:
    return MODELS[request.param][0]()


@pytest.fixture(scope="module")
def symbolic(model: Any) -> SymbolicModel:
    return SymbolicModel(model)


@pytest.fixture(scope="module")
def states(model: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(1)
    return [random_state(model, rng) for _ in range(STATES)]


def random_state(model: Any, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    q = rng.uniform(-1.5, 1.5, model.nq)
    q[3:7] /= np.linalg.norm(q[3:7])
    return q, rng.choice([-1.0, 1.0], model.nv) * rng.uniform(0.2, 2.0, model.nv)


def frames_of(model: Any) -> list[str]:
    known = [frame.name for frame in model.frames]
    for _, frames in MODELS.values():
        if frames is not None and set(frames) <= set(known):
            return list(frames)
    return [known[index] for index in (2, len(known) // 2, -1)]


def numeric_frame(model: Any, name: str, q: np.ndarray, v: np.ndarray, axes: Any) -> list[Any]:
    data, frame = model.createData(), model.getFrameId(name)
    pinocchio.forwardKinematics(model, data, q, v, np.zeros(model.nv))
    pinocchio.updateFramePlacements(model, data)
    drift = pinocchio.getFrameClassicalAcceleration(model, data, frame, axes).vector
    J = pinocchio.computeFrameJacobian(model, model.createData(), q, frame, axes)
    return [data.oMf[frame].translation, data.oMf[frame].rotation, J, drift]


def assert_close(found: Any, expected: np.ndarray) -> None:
    expected = np.array(expected).reshape(len(expected), -1)
    scale = max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(np.array(found), expected, rtol=0, atol=TOLERANCE * scale)


def test_sizes_are_those_of_the_model(model: Any, symbolic: SymbolicModel) -> None:
    assert (symbolic.nq, symbolic.nv) == (model.nq, model.nv)


def test_mass_matrix(model: Any, symbolic: SymbolicModel, states: Any) -> None:
    mass_matrix = symbolic.mass_matrix()
    for q, _ in states:
        upper = np.triu(pinocchio.crba(model, model.createData(), q))
        assert_close(mass_matrix(q), upper + np.triu(upper, 1).T)


def test_bias_forces(model: Any, symbolic: SymbolicModel, states: Any) -> None:
    bias_forces = symbolic.bias_forces()
    for q, v in states:
        assert_close(bias_forces(q, v), pinocchio.nonLinearEffects(model, model.createData(), q, v))


def test_center_of_mass(model: Any, symbolic: SymbolicModel, states: Any) -> None:
    center_of_mass = symbolic.center_of_mass()
    for q, v in states:
        data = model.createData()
        pinocchio.centerOfMass(model, data, q, v, np.zeros(model.nv))
        c, J, drift = center_of_mass(q, v)
        assert_close(c, data.com[0])
        assert_close(J, pinocchio.jacobianCenterOfMass(model, model.createData(), q))
        assert_close(drift, data.acom[0])


@pytest.mark.parametrize("local", [True, False], ids=["local", "world aligned"])
def test_frames(model: Any, symbolic: SymbolicModel, states: Any, local: bool) -> None:
    axes = pinocchio.LOCAL if local else pinocchio.LOCAL_WORLD_ALIGNED
    for name in frames_of(model):
        frame = symbolic.frame(name, local=local)
        for q, v in states:
            for found, expected in zip(
                frame(q, v), numeric_frame(model, name, q, v, axes), strict=True
            ):
                assert_close(found, expected)


def test_drifts_are_the_derivative_of_the_jacobians(
    model: Any, symbolic: SymbolicModel, states: Any
) -> None:
    center_of_mass = symbolic.center_of_mass()
    step = 1e-6

    def check(function: Any, q: np.ndarray, v: np.ndarray, J: int, drift: int) -> None:
        ahead, behind = (
            np.array(function(pinocchio.integrate(model, q, sign * step * v), v)[J]) @ v
            for sign in (1, -1)
        )
        found = np.array(function(q, v)[drift])[:, 0]
        np.testing.assert_allclose(found, (ahead - behind) / (2 * step), atol=1e-6, rtol=1e-6)

    for q, v in states[:5]:
        check(center_of_mass, q, v, 1, 2)
        for name in frames_of(model):
            check(symbolic.frame(name, local=False), q, v, 2, 3)


def test_local_drift_is_the_world_aligned_one_turned(
    model: Any, symbolic: SymbolicModel, states: Any
) -> None:
    name = frames_of(model)[0]
    local, world = (symbolic.frame(name, local=flag) for flag in (True, False))
    for q, v in states[:5]:
        _, R, _, drift = (np.array(part) for part in world(q, v))
        turned = np.concatenate((R.T @ drift[:3, 0], R.T @ drift[3:, 0]))
        assert_close(local(q, v)[3], turned)


@pytest.mark.parametrize(
    ("joint", "kind"),
    [
        (pinocchio.JointModelSpherical(), "JointModelSpherical"),
        (pinocchio.JointModelRUBX(), "JointModelRUBX"),
    ],
)
def test_unsupported_joint_is_named(joint: Any, kind: str) -> None:
    model = pinocchio.Model()
    base = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "base")
    model.addJoint(base, joint, pinocchio.SE3.Identity(), "odd_one")
    with pytest.raises(UnsupportedJoint, match="odd_one") as caught:
        SymbolicModel(model)
    assert (caught.value.joint, caught.value.joint_type) == ("odd_one", kind)
    assert "JointModelRX" in str(caught.value)


def test_unknown_frame_lists_the_known_ones(robot: Robot) -> None:
    with pytest.raises(KeyError, match="no_such_frame") as caught:
        SymbolicModel(robot.model).frame("no_such_frame", local=True)
    assert "L_sole" in str(caught.value)
    assert "torso" in str(caught.value)
