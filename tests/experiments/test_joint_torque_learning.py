from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio
import pytest

from tsd_casadi import Controller, PeriodicBasis, Robot, Squat, State
from tsd_casadi.exceptions import EntryNotFound, InvalidValue, SimulationError
from tsd_casadi.motions.motion import Reference
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_clients import MujocoSimulator
from tsd_experiments.comparison.baselines.generalize_torques import generalize_torques
from tsd_experiments.comparison.baselines.joint_torque_learning import (
    FeedbackTorque,
    add_feedback,
    learn_joint_torques,
)
from tsd_experiments.comparison.baselines.torque_feedforward import LearnedTorque, TorqueFeedforward

SQUAT = Squat(0.02, 1.0)
AXES = ("com.z",)


@pytest.fixture
def setting(robot: Robot, controller: Controller) -> Setting:
    index = np.array([controller.format.axis_index("com", "z")])
    return Setting(robot, controller, SQUAT, AXES, 1, index, 1e-3)


def ask(setting: Setting, state: State, offset: float) -> tuple[Moment, np.ndarray]:
    command = setting.controller.command()
    command["com.reference"][2] += offset
    zero = np.zeros(1)
    moment = Moment(0.0, 0.0, 0, state, Reference(zero, zero, zero), zero, command)
    moment.tick = setting.controller.tick(state, command)
    moment.tau = moment.tick.tau
    recorder = FeedbackTorque()
    recorder.start(setting)
    request = command.request.copy()
    recorder.after(moment)
    np.testing.assert_array_equal(command.request, request)
    (torque,) = recorder.torques
    return moment, torque


def test_no_feedback_no_torque(setting: Setting, robot: Robot) -> None:
    _, torque = ask(setting, robot.home, 0.0)
    assert np.abs(torque).max() < 1e-6


def test_feedback_torque_lifts_the_mass_as_asked(setting: Setting, robot: Robot) -> None:
    """The torque accelerates the robot, feet still, by what the feedback asked for."""
    moment, torque = ask(setting, robot.home, 0.004)
    assert moment.tick is not None
    model, data = robot.model, robot.model.createData()
    q = robot.home.q
    M = pinocchio.crba(model, data, q)
    M = np.triu(M) + np.triu(M, 1).T
    J = np.vstack(
        [
            pinocchio.computeFrameJacobian(
                model, data, q, model.getFrameId(contact.frame), pinocchio.LOCAL
            )
            for contact in robot.description.contacts
        ]
    )
    kkt = np.block([[M, -J.T], [J, np.zeros((len(J), len(J)))]])
    side = np.concatenate((np.zeros(6), torque, np.zeros(len(J))))
    qdd = np.linalg.solve(kkt, side)[: robot.nv]
    J_com = pinocchio.jacobianCenterOfMass(model, data, q)
    feedback = moment.tick.feedback[setting.index[0]]
    assert feedback == pytest.approx(50 * 0.004)
    np.testing.assert_allclose(J_com @ qdd, [0, 0, feedback], atol=2e-3 * feedback)


def test_learned_torque_is_added_at_its_phase(setting: Setting, robot: Robot) -> None:
    learned = TorqueFeedforward.zero(robot.joint_names, SQUAT.parameters)
    phases = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    signals = np.outer(np.arange(1.0, robot.n + 1), np.sin(phases))
    learned = replace(learned, weights=learned.basis.fit(phases, signals))
    correction = LearnedTorque(learned)
    correction.start(setting)
    moment, _ = ask(setting, robot.home, 0.0)
    moment.phase = 2 * np.pi + 0.7
    before = moment.tau.copy()
    correction.after(moment)
    expected = np.arange(1.0, robot.n + 1) * np.sin(0.7)
    np.testing.assert_allclose(moment.tau - before, expected, rtol=1e-2)
    with pytest.raises(SimulationError, match="torques are for other"):
        LearnedTorque(replace(learned, joints=("other",))).start(setting)


def test_learning_reduces_the_error(robot: Robot, controller: Controller) -> None:
    simulator = MujocoSimulator(robot, 0.1)
    runs, learned = learn_joint_torques(simulator, controller, SQUAT, 2, laps=2)
    shown = simulator.run(controller, SQUAT, axes=AXES, compensators=[LearnedTorque(learned)])
    first, second, last = (run.errors["com.z"].rms for run in (*runs, shown))
    assert second < first / 10
    assert last < second / 3
    assert learned.weights.shape == (robot.n, PeriodicBasis().L)
    assert learned.joints == tuple(robot.joint_names)
    assert learned.parameters == SQUAT.parameters


def test_nothing_is_learned_from_a_fall(robot: Robot, controller: Controller) -> None:
    simulator = MujocoSimulator(robot, 0.1)
    run = simulator.run(controller, SQUAT, laps=2)
    nothing = TorqueFeedforward.zero(robot.joint_names, SQUAT.parameters)
    for edit, word in (
        ({"fell": True}, "fell"),
        ({"failures": {"singular": 1}}, "failed ticks"),
        ({"steady": False}, "settle"),
    ):
        with pytest.raises(SimulationError, match=word):
            add_feedback(nothing, replace(run, **edit), FeedbackTorque())
    with pytest.raises(InvalidValue, match="iterations"):
        learn_joint_torques(simulator, controller, SQUAT, 0)


def test_generalised_torques_follow_the_amplitude() -> None:
    basis = PeriodicBasis()
    shape = np.random.default_rng(0).normal(size=(2, basis.L))
    learned = [
        TorqueFeedforward(
            ("a", "b"), basis, (1 + 20 * A) * shape, {"amplitude": A, "frequency": 0.5}
        )
        for A in (0.02, 0.04, 0.06, 0.08)
    ]
    asked = {"amplitude": 0.05, "frequency": 0.5}
    predicted = generalize_torques(Squat.declaration(), learned, asked)
    assert predicted.parameters == asked
    np.testing.assert_allclose(predicted.weights, 2.0 * shape, atol=0.03)
    with pytest.raises(EntryNotFound):
        generalize_torques(Squat.declaration(), learned[:1], asked)
    with pytest.raises(InvalidValue, match="learned"):
        generalize_torques(Squat.declaration(), [], asked)
