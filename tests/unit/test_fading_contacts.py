"""Contacts between there and not there."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import pytest
import quadprog
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Command, Controller, InverseDynamics, Robot, Status, Tick
from tsd_casadi.costs.force_regularization import (
    LEAST_FADING,
    fading_weight,
    share_wanted_forces,
)
from tsd_casadi.formulation.contact import MAXIMUM_LOAD
from tsd_casadi.formulation.quadratic_program import QuadraticProgram

shares = st.floats(1e-6, 1.0)


@pytest.fixture(scope="module", params=["robot", "mini_quadruped"])
def standing(request: pytest.FixtureRequest) -> Robot:
    return request.getfixturevalue(request.param)


@cache
def made(robot: Robot) -> tuple[InverseDynamics, Controller]:
    from tsd_casadi import compile_controller

    return InverseDynamics(robot), compile_controller(robot, on_compile=lambda: None)


def solve_second(program: QuadraticProgram, nv: int, n_equalities: int) -> np.ndarray:
    A = np.vstack((program.A, np.eye(nv, program.A.shape[1])))
    lower = np.concatenate((program.lower[nv:], program.lower[:nv]))
    upper = np.concatenate((program.upper[nv:], program.upper[:nv]))
    below, above = lower[n_equalities:] > -1e29, upper[n_equalities:] < 1e29
    C = np.vstack((A[:n_equalities], A[n_equalities:][below], -A[n_equalities:][above]))
    b = np.concatenate(
        (lower[:n_equalities], lower[n_equalities:][below], -upper[n_equalities:][above])
    )
    scale = 1 / np.sqrt(np.diag(program.H))
    norms = np.linalg.norm(C * scale, axis=1)
    x = quadprog.solve_qp(
        program.H * scale * scale[:, None],
        -program.g * scale,
        (C * scale).T / norms,
        b / norms,
        n_equalities,
    )[0]
    return np.asarray(x * scale)


def draw(problem: InverseDynamics, rng: np.random.Generator) -> Command:
    """A posture near home, one contact all there, the others anywhere."""
    command = Command(problem.request)
    command["q"][7:] += rng.normal(scale=0.02, size=problem.n)
    command["v"] = rng.normal(scale=0.05, size=problem.nv)
    names = [contact.name for contact in problem.contacts]
    for name in names:
        command[f"{name}.active"] = rng.choice([1.0, 10 ** rng.uniform(-6, 0)])
    command[f"{rng.choice(names)}.active"] = 1.0
    for task in problem.tasks:
        command[f"{task.name}.reference_acceleration"] = rng.normal(scale=0.3, size=task.k)
    return command


def test_a_second_solver_finds_the_same(standing: Robot) -> None:
    problem, controller = made(standing)
    rng, solved, bound = np.random.default_rng(0), 0, 0
    for _ in range(60):
        command = draw(problem, rng)
        tick = Tick(controller.format, controller.run(command.request))
        assert tick.status in (Status.OK, Status.INFEASIBLE)
        program = problem.evaluate(command.request)
        if tick.status == Status.INFEASIBLE:
            with pytest.raises(ValueError, match="inconsistent"):
                solve_second(program, problem.nv, problem.n_equalities)
            continue
        x = solve_second(program, problem.nv, problem.n_equalities)
        h_a = np.array(problem.qp(command.request)[problem.qp.index_out("h_a")])[:, 0]
        torque = program.A[-problem.n :] @ x + h_a
        np.testing.assert_allclose(tick.tau, torque, rtol=0, atol=1e-6 * (1 + abs(torque).max()))
        for name, wrench in tick.wrenches.items():
            active = float(command[f"{name}.active"][0])
            most = active * MAXIMUM_LOAD * standing.weight
            assert wrench[2] <= most + 1e-6 * (1 + most)
            # the cone is what friction and the sole leave of that
            friction = command[f"{name}.friction"][0] / np.sqrt(2)
            assert np.abs(wrench[:2]).max() <= friction * most + 1e-6 * (1 + most)
            assert wrench[2] >= active * command[f"{name}.minimum_force"][0] - 1e-5
            bound += f"{name}.unilateral_force" in tick.active
        solved += 1
    print(standing.name, solved, bound)
    assert solved > 30
    assert bound > 5


def test_a_contact_holds_its_foot_until_it_is_gone(standing: Robot) -> None:
    problem, controller = made(standing)
    name = problem.contacts[0].name
    command = controller.command()
    command[f"{name}.active"] = 1e-9
    reply = controller.tick(standing.home, command)
    program = problem.evaluate(command.request)
    rows = [problem.row_names.index(row) for row in problem.row_names if f"{name}.acc" in row]
    places = np.array(rows) - problem.nv
    x = np.concatenate((reply.qdd, np.zeros(problem.nx - problem.nv)))
    np.testing.assert_allclose(program.A[places] @ x, program.lower[rows], atol=1e-8)
    assert np.abs(reply.wrenches[name]).max() < 1e-5


def test_the_wrench_goes_to_zero_as_its_contact_does(standing: Robot) -> None:
    _, controller = made(standing)
    name = controller.format.contacts[0]
    command, force = controller.command(), []
    for active in (*np.geomspace(1, 1e-7, 40), 0.0):
        command[f"{name}.active"] = active
        tick = controller.tick(standing.home, command)
        if tick.status == Status.OK:
            force.append(tick.wrenches[name][2])
    assert len(force) > 30
    assert abs(force[-1]) < 1e-9
    assert (np.diff(force) <= 1e-6 * standing.weight).all()


def test_the_default_maximum_is_twice_the_weight(standing: Robot) -> None:
    _, controller = made(standing)
    for name in controller.format.contacts:
        assert controller.command()[f"{name}.maximum_force"][0] == 2.0 * standing.weight


# what is wanted


def shared(active: list[float], wanted: list[list[float]]) -> list[np.ndarray]:
    symbols = [ca.SX(ca.DM(forces)) for forces in wanted]
    found = share_wanted_forces([ca.SX(a) for a in active], symbols)
    return [np.array(ca.DM(ca.evalf(each)))[:, 0] for each in found]


@given(active=st.lists(shares, min_size=2, max_size=4), data=st.data())
def test_those_that_stand_share_the_weight(active: list[float], data: st.DataObject) -> None:
    push = st.floats(1.0, 500.0)
    wanted = [[0.0, 1.0, data.draw(push), 2.0, 0.0, 0.0] for _ in active]
    found = shared(active, wanted)
    assert sum(f[2] for f in found) == pytest.approx(sum(f[2] for f in wanted))
    more = found[0][2] / active[0] / wanted[0][2]
    for a, before, after in zip(active, wanted, found, strict=True):
        np.testing.assert_allclose(after, a * more * np.array(before), rtol=1e-9)


def test_a_contact_that_is_gone_is_wanted_to_carry_nothing() -> None:
    gone, other = shared([0.0, 1.0], [[0, 0, 100.0], [0, 0, 300.0]])
    assert not gone.any()
    assert other[2] == pytest.approx(400.0)


@pytest.mark.parametrize("wanted", [0.0, -5.0])
def test_where_nothing_pushes_nothing_is_shared(wanted: float) -> None:
    found = shared([0.5, 1.0], [[1.0, 0, wanted], [2.0, 0, wanted]])
    np.testing.assert_allclose(found, [[0.5, 0, 0.5 * wanted], [2.0, 0, wanted]])


def test_nobody_left_carries_nothing() -> None:
    assert not np.any(shared([0.0, 0.0], [[1.0, 0, 5.0], [2.0, 0, 5.0]]))


@pytest.mark.parametrize(
    ("active", "times"),
    [(1.0, 1.0), (0.5, 2.0), (LEAST_FADING, 1e3), (0.5 * LEAST_FADING, 1e3), (0.0, 1e3)],
)
def test_the_weight_grows_while_a_contact_fades(active: float, times: float) -> None:
    found = np.array(ca.DM(ca.evalf(fading_weight(ca.SX(ca.DM([1.0, 3.0])), ca.SX(active)))))
    np.testing.assert_allclose(found[:, 0], [times, 3 * times])


# where a tick fails


def test_the_safe_torque_follows_its_contacts(standing: Robot) -> None:
    problem, controller = made(standing)
    name, command = controller.format.contacts[0], controller.command()
    command["q"] = standing.home.q
    torques = []
    for active in (*np.linspace(1, 0.01, 100), 1e-4, 1e-7, 0.0):
        command[f"{name}.active"] = active
        torques.append(np.array(problem.safe_torque(command.request))[:, 0])
    steps = np.abs(np.diff(torques, axis=0)).max(axis=1)
    whole = np.abs(torques[-1] - torques[0]).max()
    assert whole > 1.0
    assert steps.max() < 0.1 * whole
