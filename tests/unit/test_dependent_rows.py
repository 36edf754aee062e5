"""Contacts that hold a robot in more ways than it can move."""

from __future__ import annotations

from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import quadprog
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Command, Controller, InverseDynamics, Status, Tick, compile_controller
from tsd_casadi.formulation.dependent_rows import (
    DEPENDENT,
    INDEPENDENT,
    hold_independent_rows,
    sort_rows,
)
from tsd_casadi.formulation.quadratic_program import QuadraticProgram
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.tick.row_state import RowState

ROBOTS = Path(__file__).parents[1] / "robots"
# legs of five joints on soles; four legs of two joints, and of three, on points
FILES = {
    "five_joints": ROBOTS / "mini_biped" / "five_joints.yaml",
    "two_joints": ROBOTS / "mini_quadruped" / "two_joints.yaml",
    "mini_quadruped": ROBOTS / "mini_quadruped" / "mini_quadruped.yaml",
}
# how many rows follow from others while the legs move alike
REDUNDANT = {"five_joints": 1, "two_joints": 2, "mini_quadruped": 0}
TORQUE = 1e-6  # N m
# a singular value's share of the largest that is rounding
RANK = 1e-9


@cache
def robot_of(name: str) -> tuple[InverseDynamics, Controller]:
    robot = load_robot(FILES[name])
    return InverseDynamics(robot), compile_controller(robot, on_compile=lambda: None)


@pytest.fixture(scope="module", params=FILES)
def made(request: pytest.FixtureRequest) -> tuple[InverseDynamics, Controller]:
    return robot_of(request.param)


def solve_second(
    H: np.ndarray, g: np.ndarray, C: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """Without equalities, by quadprog."""
    below, above = lower > -1e29, upper < 1e29
    rows = np.vstack((C[below], -C[above]))
    bounds = np.concatenate((lower[below], -upper[above]))
    scale = 1 / np.sqrt(np.diag(H))
    norms = np.maximum(np.linalg.norm(rows * scale, axis=1), 1e-12)
    z = quadprog.solve_qp(
        H * scale * scale[:, None], -g * scale, (rows * scale).T / norms, bounds / norms
    )[0]
    return np.asarray(z * scale)


def second_solution(program: QuadraticProgram, nv: int, n_equalities: int) -> np.ndarray:
    """By the null space that a singular value decomposition gives, whatever the rank is."""
    A, b = program.A[:n_equalities], program.lower[nv : nv + n_equalities]
    values, Vt = np.linalg.svd(A)[1:]
    rank = int(np.sum(values > RANK * values[0]))
    x_0, Z = np.linalg.pinv(A, RANK) @ b, Vt[rank:].T
    C = np.vstack((np.eye(nv, A.shape[1]), program.A[n_equalities:]))
    index = np.r_[:nv, nv + n_equalities : len(program.lower)]
    there = C @ x_0
    z = solve_second(
        Z.T @ program.H @ Z,
        Z.T @ (program.H @ x_0 + program.g),
        C @ Z,
        program.lower[index] - there,
        program.upper[index] - there,
    )
    return np.asarray(x_0 + Z @ z)


def torque(problem: InverseDynamics, request: np.ndarray, x: np.ndarray) -> np.ndarray:
    h_a = np.array(problem.qp(request)[problem.qp.index_out("h_a")])[:, 0]
    return np.asarray(problem.evaluate(request).A[-problem.n :] @ x + h_a)


def draw(problem: InverseDynamics, rng: np.random.Generator, alike: bool) -> Command:
    command = Command(problem.request)
    # about axes that all legs have in common, so that their rows follow from each other exactly
    turns = {kind: rng.normal(scale=0.05) for kind in ("ankle", "bend", "lift", "pitch", "slide")}
    for index, joint in enumerate(problem.robot.joint_names):
        command["q"][7 + index] += turns.get(joint.split("_")[-1], 0.0)
    if not alike:
        command["q"][7:] += rng.choice([-1, 1], problem.n) * rng.uniform(0.05, 0.2, problem.n)
    for task in problem.tasks:
        command[f"{task.name}.reference_acceleration"] = rng.normal(size=task.k)
    command["limits.torque"] *= rng.choice([0.2, 1.0])
    for contact in problem.contacts:
        command[f"{contact.name}.friction"] *= rng.choice([0.2, 1.0])
    command["limits.position_active"] = 0.0
    return command


def test_torques_are_those_of_a_second_solver(made: tuple[InverseDynamics, Controller]) -> None:
    problem, controller = made
    rng, seen = np.random.default_rng(0), Counter[str]()
    worst = 0.0
    for index in range(80):
        alike = index % 2 == 0
        command = draw(problem, rng, alike)
        tick = Tick(controller.format, controller.run(command.request))
        assert tick.status in (Status.OK, Status.INFEASIBLE)
        if tick.status != Status.OK:
            continue
        states = tick.reply[controller.format.reply.slice("active")]
        left_out = int(np.sum(states == RowState.DEPENDENT))
        if left_out and not alike:
            continue  # in between: the next test
        program = problem.evaluate(command.request)
        x = second_solution(program, problem.nv, problem.n_equalities)
        worst = max(worst, np.abs(tick.tau - torque(problem, command.request, x)).max())
        assert left_out == (REDUNDANT[problem.robot.name] if alike else 0)
        seen["alike" if alike else "not alike"] += 1
        seen["at a limit"] += bool(tick.active)
    print(problem.robot.name, worst, seen)
    assert worst <= TORQUE
    assert min(seen["alike"], seen["at a limit"]) > 5
    # legs of two joints stay in their planes, however they are moved
    assert seen["not alike"] > 5 or problem.robot.name == "two_joints"


def test_rows_in_between_are_those_of_the_definition() -> None:
    problem, controller = robot_of("five_joints")
    nv, meq = problem.nv, problem.n_equalities
    rng, shares = np.random.default_rng(1), []
    for _ in range(40):
        command = draw(problem, rng, alike=True)
        # velocities that the contacts do not have, too: rows that ask for something
        command["v"] = rng.normal(scale=0.05, size=nv)
        command["q"][7:] += rng.normal(scale=0.02, size=problem.n)
        tick = Tick(controller.format, controller.run(command.request))
        assert tick.status in (Status.OK, Status.INFEASIBLE)
        program = problem.evaluate(command.request)
        rows = sort_rows(program.A[:meq], program.lower[nv : nv + meq])
        if tick.status != Status.OK or not rows.partly:
            continue
        states = tick.reply[controller.format.reply.slice("active")][nv : nv + meq]
        expected = np.full(meq, float(RowState.DEPENDENT))
        expected[rows.held] = RowState.EQUALITY
        np.testing.assert_array_equal(states, expected)
        held = hold_independent_rows(program, meq)
        x = second_solution(held, nv, len(rows.held))
        assert np.abs(tick.tau - torque(problem, command.request, x)).max() <= TORQUE
        shares.append(rows.partly[0].share)
    print(sorted(shares))
    assert len(shares) > 8


@pytest.mark.parametrize("seed", range(3))
def test_torques_change_little_while_a_row_drops_out(seed: int) -> None:
    # from legs that move alike into a stance in which each row counts
    problem, controller = robot_of("five_joints")
    nv, meq = problem.nv, problem.n_equalities
    rng = np.random.default_rng(seed)
    command = Command(problem.request)
    command["posture.P"] = command["limits.position_active"] = 0.0
    for task in problem.tasks:
        command[f"{task.name}.reference_acceleration"] = rng.normal(size=task.k)
        command[f"{task.name}.P"] = 0.0
    # legs that roll differently turn their feet differently
    way = rng.normal(scale=0.3, size=problem.n)
    way[problem.robot.joint_names.index("near_roll")] = rng.choice([-1, 1])
    home = command["q"][7:].copy()

    def at(s: float) -> tuple[np.ndarray, float]:
        command["q"][7:] = home + s * way
        tick = Tick(controller.format, controller.run(command.request))
        assert tick.status == Status.OK
        program = problem.evaluate(command.request)
        rows = sort_rows(program.A[:meq], program.lower[nv : nv + meq])
        if rows.partly:
            return tick.tau, rows.partly[0].share
        return tick.tau, 0.0 if len(rows.left_out) else 1.0

    # where it begins and ends to be held, by halving
    ends = []
    for share in (1e-9, 1.0):
        low, high = 0.0, 0.3
        while high - low > 1e-7:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if at(middle)[1] >= share else (middle, high)
        ends.append((low, high))
    (before, first), (_, last) = ends
    # at both ends nothing happens, whatever was reached in between
    for low, high in ends:
        assert np.abs(at(high)[0] - at(low)[0]).max() < 1e-3
    torques = np.array([at(s)[0] for s in np.linspace(first, last, 201)])
    steps = np.abs(np.diff(torques, axis=0)).max(axis=1)
    whole = np.abs(np.ptp(torques, axis=0)).max()
    print(before, last, whole, steps.max())
    # a two-hundredth of the way changes a fiftieth of what the row makes, at most
    assert steps.max() < 0.02 * whole + 1e-3


# the rule itself


def rows_at(distance: float) -> np.ndarray:
    """Two rows of length 1, the second at a distance from the first."""
    return np.array([[1.0, 0.0, 0.0], [np.sqrt(1 - distance**2), distance, 0.0]])


def test_a_row_is_held_by_its_distance_from_the_others() -> None:
    below, above = 1 - 1e-6, 1 + 1e-6
    for distance, held, partly, left_out in (
        (0.0, 1, 0, 1),
        (below * DEPENDENT, 1, 0, 1),
        (above * DEPENDENT, 1, 1, 0),
        (below * INDEPENDENT, 1, 1, 0),
        (above * INDEPENDENT, 2, 0, 0),
    ):
        rows = sort_rows(rows_at(distance), np.array([0.3, -0.2]))
        assert (len(rows.held), len(rows.partly), len(rows.left_out)) == (held, partly, left_out)


@given(
    distance=st.floats(1.001 * DEPENDENT, 0.999 * INDEPENDENT),
    b=st.tuples(st.floats(-1, 1), st.floats(-1, 1)).map(np.array),
)
def test_what_a_row_asks_for_beside_the_others(distance: float, b: np.ndarray) -> None:
    A = 3.0 * rows_at(distance)
    (part,) = sort_rows(A, b).partly
    np.testing.assert_allclose(np.abs(part.normal), [0, 1, 0], atol=1e-12)
    x = np.array([b[0] / 3.0, part.value * part.normal[1], 0.0])
    np.testing.assert_allclose(A @ x, b, atol=1e-9)
    assert part.share == pytest.approx((distance - DEPENDENT) / (INDEPENDENT - DEPENDENT))


def test_a_programs_other_rows_stay() -> None:
    A = np.vstack((rows_at(0.0), [0.0, 0.0, 1.0]))
    program = QuadraticProgram(
        np.eye(3), np.ones(3), A, np.array([-1.0, 1, 2, 3]), np.array([1.0, 1, 2, 4])
    )
    found = hold_independent_rows(program, 2)
    np.testing.assert_array_equal(found.A, A[[0, 2]])
    np.testing.assert_array_equal(found.lower, [-1, 1, 3])
    np.testing.assert_array_equal(found.upper, [1, 1, 4])
    np.testing.assert_array_equal(found.H, program.H)
