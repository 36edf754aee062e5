"""Tasks that come and go: weights, projection and torques that go over without a jump."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tsd_casadi import Command, Controller, Robot, Status, Tick
from tsd_casadi.costs.null_space_posture import null_space_projector
from tsd_casadi.tasks.activation import LEAST_WEIGHT, blended_weight, weight_shares

ROWS, NV = 7, 9
STEPS = 100

shares = st.floats(0, 1)
weights = st.floats(1e-6, 1e4)


def shares_of(level: float, weight: float, rest: float) -> float:
    return float(ca.evalf(weight_shares(ca.SX(level), ca.SX(weight), ca.SX(rest))))


@given(level=shares, weight=weights, rest=weights)
def test_what_is_left_of_a_weight_is_in_series_with_what_takes_over(
    level: float, weight: float, rest: float
) -> None:
    f = shares_of(level, weight, rest)
    assert 0 <= f <= 1
    if 1e-9 < level < 1:
        assert 1 / (f * weight) == pytest.approx(1 / weight + (1 - level) / (level * rest))


@pytest.mark.parametrize("weight", [0.0, LEAST_WEIGHT / 2, LEAST_WEIGHT, 1.0])
@pytest.mark.parametrize("rest", [0.0, LEAST_WEIGHT / 2, LEAST_WEIGHT, 1.0])
def test_nothing_and_all_of_a_weight_are_exact(weight: float, rest: float) -> None:
    assert shares_of(0.0, weight, rest) == 0.0
    assert shares_of(1.0, weight, rest) == 1.0
    assert 0 < shares_of(0.5, weight, rest) < 1


@given(level=arrays(float, 3, elements=shares), seed=st.integers(0, 99))
def test_a_blended_weight_stays_positive_semidefinite(level: np.ndarray, seed: int) -> None:
    root = np.random.default_rng(seed).normal(size=(3, 3))
    W = root @ root.T
    found = np.array(ca.evalf(blended_weight(ca.SX(ca.DM(W)), ca.SX(ca.DM(level)), ca.SX(0.1))))
    np.testing.assert_array_equal(found, found.T)
    assert np.linalg.eigvalsh(found).min() >= -1e-12 * np.abs(W).max()
    assert not found[level == 0].any()
    np.testing.assert_array_equal(
        found[np.ix_(level == 1, level == 1)], W[level == 1][:, level == 1]
    )


@cache
def projector() -> ca.Function:
    J, level = ca.MX.sym("J", ROWS, NV), ca.MX.sym("level", ROWS)
    return ca.Function("P", [J, level], [null_space_projector(J, level)])


def project(J: np.ndarray, level: np.ndarray) -> np.ndarray:
    return np.array(projector()((level > 0)[:, None] * J, level))


levels = arrays(float, ROWS, elements=st.sampled_from([0.0, 0.2, 0.5, 1.0]))


@given(seed=st.integers(0, 99), level=levels, s=shares)
def test_a_row_on_its_way_goes_over_from_without_to_with(
    seed: int, level: np.ndarray, s: float
) -> None:
    # rows that are there or not, and one of a task on its way
    J, level = np.random.default_rng(seed).normal(size=(ROWS, NV)), np.round(level)
    N = []
    for level[3] in (0.0, s, 1.0):
        N.append(project(J, level))
    np.testing.assert_allclose(N[1], (1 - s) * N[0] + s * N[2], atol=1e-6)


@given(seed=st.integers(0, 99), level=levels)
def test_rows_of_several_levels_go_over_without_a_jump(seed: int, level: np.ndarray) -> None:
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(ROWS, NV))
    N = project(J, level)
    # equal levels part, rows come and go, others overtake: all of it by 1e-6
    near = np.clip(level + rng.uniform(-1e-6, 1e-6, ROWS), 0, 1)
    np.testing.assert_allclose(project(J, near), N, atol=1e-4)
    # symmetric, between none and all of it, and nothing of a row that is all there
    np.testing.assert_allclose(N, N.T, atol=1e-12)
    eigenvalues = np.linalg.eigvalsh(N)
    assert eigenvalues.min() > -1e-6
    assert eigenvalues.max() < 1 + 1e-6
    assert np.abs(N @ J[level == 1].T).max(initial=0.0) < 1e-6
    order = rng.permutation(ROWS)
    np.testing.assert_allclose(project(J[order], level[order]), N, atol=1e-6)


@pytest.fixture(scope="module")
def robot(any_robot: Robot) -> Robot:
    return any_robot


@pytest.fixture(scope="module")
def controller(any_controller: Controller) -> Controller:
    return any_controller


def torques(controller: Controller, command: Command, task: str, level: float) -> np.ndarray:
    command[f"{task}.active"] = level
    tick = Tick(controller.format, controller.run(command.request))
    assert tick.status == Status.OK
    return tick.tau


def wanting(robot: Robot, controller: Controller, seed: int) -> Command:
    """Standing, while posture and tasks ask for different things."""
    rng, command = np.random.default_rng(seed), controller.command()
    command["q"], command["v"] = robot.home.q, robot.home.v
    command["posture.q_ref"] += rng.uniform(-0.05, 0.05, robot.n)
    for task in robot.description.tasks:
        command[f"{task.name}.active"] = rng.choice([0.5, 1.0])
    return command


@settings(max_examples=10)
@given(seed=st.integers(0, 9999))
def test_torques_follow_a_level_without_a_jump(
    robot: Robot, controller: Controller, seed: int
) -> None:
    command = wanting(robot, controller, seed)
    tasks = [task.name for task in robot.description.tasks]
    task = tasks[seed % len(tasks)]
    every = np.linspace(0, 1, STEPS + 1)
    tau = np.array([torques(controller, command, task, level) for level in every])
    span = np.ptp(tau, axis=0).max()
    steps = np.abs(np.diff(tau, axis=0)).max(axis=1)
    # along a free axis the steepest slope is 1.9 times the mean; of 900 postures of all robots
    # that were looked at it was 10 times at most, and half of them 2.2. A jump is STEPS times.
    assert steps.max() <= 25 * span / STEPS + 1e-9
    # no jump at the ends, where rows come and go
    for end, near in ((0.0, 1e-7), (1.0, 1 - 1e-7)):
        away = torques(controller, command, task, near) - torques(controller, command, task, end)
        assert np.abs(away).max() <= 1e-4 * span + 1e-6


def test_a_masked_axis_is_left_out(robot: Robot, controller: Controller) -> None:
    command = wanting(robot, controller, 3)
    task = robot.axis_for("", "com", "z").split(".")[0]
    command[f"{task}.active"] = 1.0
    k = len(command[f"{task}.mask"])
    for axis in range(k):
        command[f"{task}.mask"] = np.arange(k) != axis
        before = controller.run(command.request)
        for name in ("reference_velocity", "reference_acceleration", "feedforward"):
            command[f"{task}.{name}"][axis] = 0.5
        after = controller.run(command.request)
        for name in ("tau", "qdd", "wrenches"):
            place = controller.format.reply.slice(name)
            np.testing.assert_allclose(after[place], before[place], atol=1e-9)
        for name in ("reference_velocity", "reference_acceleration", "feedforward"):
            command[f"{task}.{name}"] = 0.0
