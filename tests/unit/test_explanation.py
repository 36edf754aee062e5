"""Why a tick has no solution, and what limits cost: checked by linear programs and a QP solver."""

from __future__ import annotations

import numpy as np
import pytest
import quadprog
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from benchmarks.shortest_conflicts import Search
from tsd_casadi import Command, Controller, InverseDynamics, Robot, Status, Tick
from tsd_casadi.explanation.conflict import find_conflict
from tsd_casadi.explanation.explain import explain
from tsd_casadi.explanation.explanation import Explanation
from tsd_casadi.explanation.reduced_rows import reduce_rows
from tsd_casadi.explanation.row_words import describe_row
from tsd_casadi.formulation.quadratic_program import QuadraticProgram
from tsd_casadi.state import State


def set_joint(robot: Robot, command: Command, field: str, joint: str, value: float) -> None:
    command[field][robot.joint_names.index(joint)] = value


def weak_ankle(problem: InverseDynamics) -> Command:
    """A foot that has to press in front of an ankle that can do next to nothing."""
    command = Command(problem.request)
    command["left_foot.minimum_force"] = 600.0
    command["left_foot.extents"] = [0.1, 0.12, -0.05, 0.05]
    set_joint(problem.robot, command, "limits.torque", "L_AFE", 1.0)
    return command


def spoil(problem: InverseDynamics, seed: int) -> Command:
    """Make a request that has a good chance of being infeasible, each time for other reasons."""
    rng, robot, command = np.random.default_rng(seed), problem.robot, Command(problem.request)
    # they yield before anything is infeasible
    command["limits.position_active"] = command["limits.velocity_active"] = 0.0
    command["q"][7:] += rng.normal(scale=0.1, size=robot.n)
    command["v"] = rng.normal(scale=0.3, size=robot.nv)
    names = [contact.name for contact in problem.contacts]
    for kind in rng.permutation(5)[: rng.integers(1, 4)]:
        if kind == 0:
            command["limits.torque"] *= rng.uniform(0, 0.3)
        elif kind == 1:
            command["limits.torque"][rng.integers(robot.n)] *= rng.uniform(0, 0.1)
        elif kind == 2:
            for name in names:
                command[f"{name}.minimum_force"] = rng.uniform(0, 1.5) * robot.weight
        elif kind == 3:
            for name in names:
                command[f"{name}.friction"] = rng.uniform(0, 0.02)
                command[f"{name}.extents"] *= rng.uniform(0, 0.1)
        else:
            command["limits.acceleration"] = rng.uniform(0, 3)
    return command


class Independent:
    """Asks HiGHS about rows of a QP, equalities included, none eliminated."""

    def __init__(self, problem: InverseDynamics, qp: QuadraticProgram) -> None:
        nv, n = problem.nv, problem.n_equalities
        self._A = np.vstack((np.eye(nv, qp.A.shape[1]), qp.A))
        self._qp, self._equalities = qp, slice(nv, nv + n)
        self._names = list(problem.row_names)

    @property
    def inequalities(self) -> list[str]:
        """Names of all limits."""
        first, end = self._equalities.start, self._equalities.stop
        return [name for i, name in enumerate(self._names) if not first <= i < end]

    def can_hold(self, names: list[str], give: str = "") -> float | None:
        """Least amount by which one row has to give way, None if that is not enough."""
        A, lower, upper = self._A, self._qp.lower, self._qp.upper
        rows = [self._names.index(name) for name in names]
        gives = np.array([name == give for name in names], dtype=float)[:, None]
        scale = 1 / np.linalg.norm(A[rows], axis=1)[:, None]
        above, below = ((sign * scale * A[rows], -scale * gives) for sign in (1, -1))
        bounds = np.concatenate((scale[:, 0] * upper[rows], -scale[:, 0] * lower[rows]))
        finite = np.abs(bounds) < 1e20
        equal = A[self._equalities]
        equal_scale = 1 / np.linalg.norm(equal, axis=1)[:, None]
        for presolve in (True, False):  # HiGHS sometimes gives up with one of them
            solved = linprog(
                np.eye(1, A.shape[1] + 1, A.shape[1])[0],
                A_ub=np.vstack((np.hstack(above), np.hstack(below)))[finite],
                b_ub=bounds[finite],
                A_eq=np.hstack((equal_scale * equal, np.zeros((len(equal), 1)))),
                b_eq=equal_scale[:, 0] * lower[self._equalities],
                bounds=[(None, None)] * A.shape[1] + [(0, None if give else 0)],
                options={"presolve": presolve},
            )
            if solved.status in (0, 2):
                break
        assert solved.status in (0, 2), solved.message
        return float(solved.fun) if solved.status == 0 else None


def names_of(explanation: Explanation) -> list[str]:
    return [row.name for row in explanation.conflict]


def test_a_weak_ankle(problem: InverseDynamics, controller: Controller) -> None:
    command = weak_ankle(problem)
    assert controller.tick(problem.robot.home, command).status is Status.INFEASIBLE
    found = explain(problem, command.request)
    assert not found.feasible and not found.dependent
    assert set(names_of(found)) == {
        "joint_torque.L_AFE",
        "left_foot.center_of_pressure.-x",
        "left_foot.friction.-x",
        "left_foot.unilateral_force",
    }
    ankle = next(row for row in found.conflict if row.name == "joint_torque.L_AFE")
    assert (ankle.side, ankle.bound) == ("upper", pytest.approx(1.0))
    # 600 N 0.1 m in front of the ankle's axis, less what friction and the foot's weight do
    assert 60.0 - 1.0 < ankle.alone < 90.0
    assert "joint_torque.L_AFE" in found.sentence()


def test_a_shorter_set_is_looked_for_and_proved(problem: InverseDynamics) -> None:
    """By what the docs' bounds of sets come from."""
    command = weak_ankle(problem)
    command["limits.position_active"] = command["limits.velocity_active"] = 0.0
    program = problem.evaluate(command.request)
    search = Search(reduce_rows(program, problem.nv, problem.n_equalities), shortest=18)
    search.run(seconds=60.0)  # it takes one or two
    assert search.least == search.shortest == 4


def test_more_normal_force_than_joints_may_lift(problem: InverseDynamics) -> None:
    """Both feet together pressing with three weights throw the robot up with 2 g."""
    command = Command(problem.request)
    for side in ("left_foot", "right_foot"):
        command[f"{side}.minimum_force"] = 1.5 * problem.robot.weight
    assert explain(problem, command.request).feasible
    command["limits.acceleration"] = 3.0
    found = explain(problem, command.request)
    names = names_of(found)
    assert {"left_foot.unilateral_force", "right_foot.unilateral_force"} <= set(names)
    is_bound = [name.startswith("joint_acceleration") for name in names]
    assert is_bound == sorted(is_bound)  # limits of accelerations last


def test_what_can_hold_has_no_conflict(problem: InverseDynamics) -> None:
    found = explain(problem, Command(problem.request).request)
    assert found.feasible and found.conflict == () and found.limits == ()
    assert found.otherwise is not None and max(map(abs, found.otherwise.values())) < 1e-5


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_sets_are_irreducible_and_violations_the_least(problem: InverseDynamics, seed: int) -> None:
    request = spoil(problem, seed).request
    qp = problem.evaluate(request)
    independent = Independent(problem, qp)
    found = explain(problem, request)
    assert found.feasible == (independent.can_hold(independent.inequalities) is not None)
    names = names_of(found)
    assert len(set(names)) == len(names)
    if names:
        assert independent.can_hold(names) is None
    for row in found.conflict:
        others = [name for name in names if name != row.name]
        assert independent.can_hold(others) is not None, row.name
        least = independent.can_hold(names, give=row.name)
        assert least == pytest.approx(row.alone, rel=1e-4, abs=1e-5)
        assert row.violation == pytest.approx(row.alone / len(names))


def ask(controller: Controller, command: Command) -> Tick:
    state = State(command["q"].copy(), command["v"].copy())
    return controller.tick(state, command)


def check_conflict(problem: InverseDynamics, command: Command, tick: Tick) -> None:
    """Irreducible, and each amount the least that is enough, as HiGHS says."""
    independent = Independent(problem, problem.evaluate(command.request))
    names = list(tick.conflict)
    assert independent.can_hold(names) is None
    for name, amount in tick.conflict.items():
        others = [other for other in names if other != name]
        assert independent.can_hold(others) is not None, name
        least = independent.can_hold(names, give=name)
        assert least == pytest.approx(abs(amount), rel=1e-4, abs=1e-5)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_the_reply_says_which_limits_cannot_hold(
    problem: InverseDynamics, controller: Controller, seed: int
) -> None:
    command = spoil(problem, seed)
    command["explain"] = 1.0
    tick = ask(controller, command)
    assert bool(tick.conflict) == (tick.status is Status.INFEASIBLE)
    if tick.conflict:
        check_conflict(problem, command, tick)


def test_the_reply_says_it_on_every_robot(any_robot: Robot, any_controller: Controller) -> None:
    """All joints lame, and feet that have to press."""
    problem, command = InverseDynamics(any_robot), any_controller.command()
    command["limits.position_active"] = command["limits.velocity_active"] = 0.0
    command["limits.acceleration"], command["explain"] = 3.0, 1.0
    command["limits.torque"] *= 0.01
    for contact in problem.contacts:
        command[f"{contact.name}.minimum_force"] = any_robot.weight
    command.set_state(any_robot.home)
    tick = ask(any_controller, command)
    assert tick.status is Status.INFEASIBLE
    if not explain(problem, command.request).dependent:
        check_conflict(problem, command, tick)


def test_the_reply_names_bound_and_side_as_the_definition(
    problem: InverseDynamics, controller: Controller
) -> None:
    command = weak_ankle(problem)
    command["explain"] = 1.0
    told = ask(controller, command).conflict
    found = explain(problem, command.request).conflict
    signed = {row.name: row.alone * (1 if row.side == "upper" else -1) for row in found}
    assert told == pytest.approx(signed, rel=1e-6)


@pytest.mark.parametrize("weak", [False, True])
def test_who_does_not_ask_or_need_it_gets_nothing_else(
    problem: InverseDynamics, controller: Controller, weak: bool
) -> None:
    """Nor does the question change the rest of the answer."""
    command = weak_ankle(problem) if weak else controller.command()
    command.set_state(problem.robot.home)
    replies = []
    for asked in (0.0, 1.0):
        command["explain"] = asked
        replies.append(ask(controller, command))
    silent, told = replies
    assert silent.conflict == {} and bool(told.conflict) is weak
    for field in controller.format.reply:
        if field.name != "conflict" and not field.name.endswith("_time"):
            place = controller.format.reply.slice(field.name)
            assert np.array_equal(silent.reply[place], told.reply[place]), field.name


def test_if_all_give_way_by_their_violations_they_hold(problem: InverseDynamics) -> None:
    command = weak_ankle(problem)
    reduced = reduce_rows(problem.evaluate(command.request), problem.nv, problem.n_equalities)
    conflict = find_conflict(reduced)
    assert conflict is not None
    G, h = reduced.G[conflict.places], reduced.h[conflict.places]
    for share, there in ((1.001, True), (0.999, False)):
        solved = linprog(
            np.zeros(G.shape[1]), A_ub=G, b_ub=h + share * conflict.violations, bounds=(None, None)
        )
        assert (solved.status == 0) is there


@pytest.mark.parametrize("seed", range(8))
def test_costs_add_up_to_what_is_missing(problem: InverseDynamics, seed: int) -> None:
    """Optimum and multipliers are those of another solver, the sum is exact."""
    rng, command = np.random.default_rng(seed), Command(problem.request)
    for name in ("com", "pelvis", "torso"):
        command[f"{name}.reference_acceleration"] = rng.normal(scale=4.0, size=3)
    command["limits.torque"] *= 0.4
    command["limits.acceleration"] = 15.0
    command["left_foot.friction"] = 0.1
    qp = problem.evaluate(command.request)
    found = explain(problem, command.request)
    assert found.feasible and found.limits
    nv, n = problem.nv, problem.n_equalities
    A = np.vstack((np.eye(nv, problem.nx), qp.A))
    equal = np.arange(nv, nv + n)
    other = np.setdiff1d(np.arange(len(A)), equal)
    rows = np.vstack((A[equal], A[other], -A[other]))
    bounds = np.concatenate((qp.lower[equal], qp.lower[other], -qp.upper[other]))
    kept = bounds > -1e29
    solution, _, _, _, multipliers, _ = quadprog.solve_qp(
        qp.H, -qp.g, rows[kept].T, bounds[kept], n
    )
    size = np.zeros(len(rows))
    size[kept] = multipliers
    found_multipliers = {limit.name: limit.multiplier for limit in found.limits}
    for place, row in enumerate(other):
        largest = max(size[n + place], size[n + len(other) + place])
        expected = found_multipliers.get(problem.row_names[row], 0.0)
        assert expected == pytest.approx(largest, rel=1e-5, abs=1e-7)
    # J qdd as asked for, minus J qdd as solved
    values = dict(zip(problem.terms.name_out(), problem.terms(command.request), strict=True))
    J = np.array(values["J"])[:9]
    free = Command(problem.request)
    still = np.array(problem.terms(free.request)[problem.terms.index_out("feedback")])[:, 0]
    assert still == pytest.approx(0.0, abs=1e-12)  # at home, at rest: no drift and no feedback
    wanted = np.concatenate(
        [command[f"{name}.reference_acceleration"] for name in ("com", "pelvis", "torso")]
    )
    missing = wanted - J @ solution[:nv]
    assert found.otherwise is not None
    total = np.array(list(found.otherwise.values()))
    for limit in found.limits:
        total += np.array(list(limit.tasks.values()))
    assert total == pytest.approx(missing, abs=1e-6)


def test_equalities_that_contradict_each_other(problem: InverseDynamics) -> None:
    """The first one is held, as in the compiled tick: feet cannot accelerate in two ways."""
    qp = problem.evaluate(Command(problem.request).request)
    nv = problem.nv
    A, lower = qp.A.copy(), qp.lower.copy()
    A[7] = A[6]
    lower[nv + 6] = lower[nv + 7] + 1.0
    program = QuadraticProgram(qp.H, qp.g, A, lower, np.maximum(lower, qp.upper))
    reduced = reduce_rows(program, nv, problem.n_equalities)
    assert list(reduced.held.left_out) == [7]
    assert A[6] @ reduced.x_0 == pytest.approx(lower[nv + 6])
    np.testing.assert_allclose(A[6] @ reduced.Z, 0, atol=1e-12)


def test_every_row_has_words(any_robot: Robot) -> None:
    problem = InverseDynamics(any_robot)
    for place, name in enumerate(problem.row_names):
        words = describe_row(name)
        if not problem.nv <= place < problem.nv + problem.n_equalities:
            assert words.unit, name
            assert words.where in name and words.what


def test_a_row_of_an_unknown_kind_keeps_its_name() -> None:
    assert describe_row("something.else").what == "something.else"


def test_limits_that_yield_are_no_reason(robot: Robot, controller: Controller) -> None:
    """Every joint beyond its stop, on feet that stand: they cannot all be led back at once."""
    command = controller.command()
    command["limits.position_lower"] = robot.home.q[7:] + 0.05
    command["limits.position_upper"] = robot.home.q[7:] + 1.0
    command.set_state(robot.home)
    tick = controller.tick(robot.home, command)
    assert tick.yielded
    assert tick.status == Status.OK
    assert explain(InverseDynamics(robot), command.request).feasible
