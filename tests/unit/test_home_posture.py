"""Home postures, looked at with Pinocchio alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_casadi.proposal.arms import hanging, sag
from tsd_casadi.proposal.body import Body
from tsd_casadi.proposal.home_posture import HomePosture, find_home_posture
from tsd_casadi.proposal.inverse_statics import torque_shares
from tsd_casadi.proposal.legs import find_legs
from tsd_casadi.proposal.posed import LEAST_BEND, LEAST_MARGIN
from tsd_casadi.proposal.propose import propose_robot_file
from tsd_casadi.proposal.survey import survey
from tsd_casadi.robot.robot import Robot

FEET = ("left_foot", "right_foot")
Write = Callable[..., Path]


@pytest.fixture
def body(small_humanoid: Write) -> Body:
    return survey(small_humanoid(), FEET, ()).body


def home_of(body: Body) -> HomePosture:
    home = find_home_posture(body)
    assert home is not None
    return home


def angle(body: Body, q: object, joint: str) -> float:
    return float(np.asarray(q)[body.model.joints[body.model.getJointId(joint)].idx_q])


def test_soles_are_flat_and_side_by_side(body: Body) -> None:
    home = home_of(body)
    data = body.model.createData()
    pinocchio.framesForwardKinematics(body.model, data, home.posed.q)
    left, right = (data.oMf[frame] for frame in body.sole_frames)
    for sole in (left, right):
        np.testing.assert_allclose(sole.rotation, np.eye(3), atol=1e-5)
        assert abs(sole.translation[2]) < 1e-5
    np.testing.assert_allclose(left.translation[0], right.translation[0], atol=1e-5)
    np.testing.assert_allclose(left.translation[1], -right.translation[1], atol=1e-5)


def test_a_symmetric_robot_stands_symmetrically(body: Body) -> None:
    q = home_of(body).posed.q
    for joint in ("hip_pitch", "knee", "ankle_pitch", "shoulder", "elbow"):
        left, right = (angle(body, q, f"{side}_{joint}") for side in ("left", "right"))
        assert left == pytest.approx(right, abs=1e-3)
    for joint in ("hip_yaw", "hip_roll", "ankle_roll"):
        assert angle(body, q, f"left_{joint}") == pytest.approx(0, abs=1e-3)


def test_it_is_a_crouch_over_the_middle_of_the_soles(body: Body) -> None:
    home = home_of(body)
    com = pinocchio.centerOfMass(body.model, body.model.createData(), home.posed.q)
    assert 1.2 < angle(body, home.posed.q, "left_knee") < 1.7
    np.testing.assert_allclose(com[:2], 0, atol=1e-4)  # the middles of the soles are at x = 0
    assert home.lean == 0
    assert home.amplitude > 0.03


def test_arms_hang_with_bent_elbows_away_from_the_stop(body: Body) -> None:
    q = home_of(body).posed.q
    assert angle(body, q, "left_elbow") < -0.15  # its stop is at 0
    assert abs(angle(body, q, "left_shoulder")) < 0.5
    assert {body.model.names[j] for j in hanging(body)} == {
        f"{side}_{joint}" for side in ("left", "right") for joint in ("shoulder", "elbow")
    }


def test_near_ankle_stops_the_body_bows(small_humanoid: Write) -> None:
    stiff = survey(small_humanoid(limits={"ankle_pitch": "-0.6 0.9"}), FEET, ()).body
    home = home_of(stiff)
    assert home.lean > 0
    distance = np.minimum(home.posed.q[7:] - stiff.low, stiff.high - home.posed.q[7:])
    assert distance.min() >= LEAST_MARGIN
    assert home.posed.bend >= LEAST_BEND


def test_legs_that_cannot_bend_are_told(small_humanoid: Write) -> None:
    path = small_humanoid(limits={"knee": "0.0 0.5"})
    with pytest.raises(RobotFileError, match=r"left_knee \[0.00, 0.50\]"):
        propose_robot_file(path, FEET, (), "stiff", path.parent / "stiff.yaml")


def test_the_knee_of_hermes_is_found_by_how_it_moves(robot: Robot) -> None:
    model = robot.model
    feet = [model.frames[frame].parentJoint for frame in robot.sole_frames]
    legs = find_legs(model, (feet[0], feet[1]))
    assert [model.names[leg.knee] for leg in legs] == ["L_KFE", "R_KFE"]
    for leg in legs:
        assert leg.bend(model, robot.home.q) == pytest.approx(1.3, abs=0.02)
        assert leg.sign == 1


def test_a_knee_is_bent_from_where_the_leg_is_longest(body: Body) -> None:
    leg = body.legs[0]
    model, data = body.model, body.model.createData()

    def length(bend: float) -> float:
        q = body.neutral()
        q[model.joints[leg.knee].idx_q] = leg.straight + leg.sign * bend
        pinocchio.forwardKinematics(model, data, q)
        ends = (data.oMi[leg.joints[0]].translation, data.oMi[leg.joints[-1]].translation)
        return float(np.linalg.norm(ends[0] - ends[1]))

    assert length(0.0) > max(length(0.01), length(-0.01))
    assert length(1.0) == pytest.approx(2 * 0.32 * np.cos(0.5), rel=1e-6)


def test_legs_without_knees_are_told(mini_biped: Robot) -> None:
    model = mini_biped.model
    feet = [model.frames[frame].parentJoint for frame in mini_biped.sole_frames]
    with pytest.raises(InvalidValue, match="a joint between hip and ankle that bends it"):
        find_legs(model, (feet[0], feet[1]))


def test_knees_bear_the_weight_above_them(body: Body) -> None:
    """Both knees together: the weight of what is above times its lever, thigh times sin."""
    home = home_of(body)
    shares = torque_shares(body, home.posed.q, np.zeros(body.model.nv))
    assert shares is not None
    model, data = body.model, body.model.createData()
    pinocchio.forwardKinematics(model, data, home.posed.q)
    knees = [model.getJointId(f"{side}_knee") for side in ("left", "right")]
    # forces from the ground act under the centre of mass, moments at the soles balance
    lever = float(data.oMi[knees[0]].translation[0])
    below = 2 * (2.0 + 0.6 + 0.8)  # kg: shanks and feet
    ideal = (body.mass - below) * 9.81 * lever
    torque = sum(shares[j - 2] * body.limit[j - 2] for j in knees)
    assert torque == pytest.approx(ideal, rel=0.25)


def test_a_robot_off_its_soles_is_not_balanced(body: Body) -> None:
    home = home_of(body)
    q = home.posed.q.copy()
    q[3:7] = pinocchio.Quaternion(pinocchio.exp3(np.array([0.0, 0.9, 0.0]))).coeffs()
    assert torque_shares(body, q, np.zeros(body.model.nv)) is None


def test_an_arm_sags_as_a_pendulum(body: Body) -> None:
    """A straight arm at the horizontal, its elbow free as well: both fall at once."""
    q = body.neutral()
    q[body.model.joints[body.model.getJointId("left_shoulder")].idx_q] = -np.pi / 2
    sagged = sag(body, q, 0.1, 40.0)
    assert sagged[body.model.getJointId("left_shoulder") - 2] > 0.02
    assert sag(body, q, 0.2, 40.0) == pytest.approx(2 * sagged)
    assert sagged[body.model.getJointId("left_knee") - 2] == 0
