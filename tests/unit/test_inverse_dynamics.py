from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pinocchio
import pytest
import quadprog
from hypothesis import settings
from scipy.spatial.transform import Rotation

from tsd_casadi import Command, Controller, InverseDynamics, Robot, Status, Tick, load_robot
from tsd_casadi.costs.null_space_posture import DAMPING, null_space_projector
from tsd_casadi.formulation.quadratic_program import QuadraticProgram
from tsd_casadi.robot.robot_file_sections import COM_AXES, FRAME_AXES
from tsd_casadi.tasks.symmetric import pack_lower_triangle
from tsd_casadi.tick.row_state import RowState

# 250 states of each kind where laws are tried on 100 examples
EACH = 5 * settings().max_examples // 2
LEAST_ACTIVE = 3
FILES = {path.stem: path for path in Path(__file__).parents[1].glob("robots/*/*.yaml")}
# shares of the torque limits that are too little every other time
WEAK = {
    "g1": 0.09,
    "hermes_lower": 0.09,
    "mini_biped": 0.003,
    "mini_quadruped": 0.09,
    "peg_leg": 0.003,
    "talos": 0.09,
}
# joints of a leg and how far each turns where the knee does
KNEES = {
    "hermes_lower": [
        ((f"{side}_HFE", -0.5), (f"{side}_KFE", 1.0), (f"{side}_AFE", -0.5)) for side in "LR"
    ],
    "mini_quadruped": [
        ((f"{leg}_lift", 0.5), (f"{leg}_bend", -1.0)) for leg in ("fl", "fr", "rl", "rr")
    ],
}


def names_of(problem: InverseDynamics, ending: str) -> list[str]:
    return [field.name for field in problem.request if field.name.endswith(ending)]


def turned(quaternion: np.ndarray, rng: np.random.Generator, angle: float) -> np.ndarray:
    away = Rotation.from_rotvec(rng.normal(scale=angle, size=3))
    return np.asarray((away * Rotation.from_quat(quaternion)).as_quat())


def random_command(
    problem: InverseDynamics, rng: np.random.Generator, noise: float = 1.0
) -> Command:
    robot, command = problem.robot, Command(problem.request)
    q = command["q"]
    q[:3] += rng.normal(scale=0.1 * noise, size=3)
    q[3:7] = turned(q[3:7], rng, 0.05 * noise)
    q[7:] += rng.normal(scale=0.05 * noise, size=robot.n)
    if rng.random() < 0.1:  # almost straight knees
        for leg in KNEES.get(robot.name, []):
            for joint, factor in leg:
                q[7 + robot.joint_names.index(joint)] = factor * rng.uniform(0.01, 0.1)
    command["v"] = rng.choice([-1, 1], robot.nv) * noise * rng.uniform(0.05, 0.15, robot.nv)
    for task in problem.tasks:
        k, name = task.k, task.name
        reference = command[f"{name}.reference"]
        reference[:3] += rng.normal(scale=0.02 * noise, size=3)
        if len(reference) == 7:
            reference[3:] = turned(reference[3:], rng, 0.1 * noise)
        command[f"{name}.reference_velocity"] = rng.normal(scale=0.1 * noise, size=k)
        command[f"{name}.reference_acceleration"] = rng.normal(scale=0.3 * noise, size=k)
        command[f"{name}.feedforward"] = rng.normal(scale=0.3 * noise, size=k)
        command[f"{name}.P"] *= rng.uniform(0.5, 1.5, k)
        command[f"{name}.D"] *= rng.uniform(0.5, 1.5, k)
        root = np.eye(k) + rng.uniform(-0.3, 0.3, (k, k))
        command[f"{name}.W"] = task.W * pack_lower_triangle(root @ root.T)
    for name in ("posture.q_ref", *names_of(problem, ".lambda_des")):
        command[name] += rng.normal(scale=0.1 * noise, size=command[name].shape)
    for name in ("posture.P", "posture.D", "posture.W", *names_of(problem, ".W_lambda")):
        command[name] *= rng.uniform(0.5, 1.5, command[name].shape)
    return command


def tighten(
    problem: InverseDynamics, command: Command, rng: np.random.Generator, share: float = 0.5
) -> None:
    command["limits.torque"] *= rng.uniform(0.3 * share, share, command["limits.torque"].shape)
    command["limits.acceleration"] = rng.uniform(5, 60, command["limits.acceleration"].shape)
    for name in names_of(problem, ".friction"):
        command[name] = rng.uniform(0.1, 0.3)
    for name in names_of(problem, ".torsional_friction"):
        command[name] = rng.uniform(0.005, 0.02)
    for name in names_of(problem, ".extents"):
        command[name] *= rng.uniform(0.2, 0.6)
    for name in names_of(problem, ".reference_acceleration"):
        command[name] += rng.normal(scale=3.0, size=command[name].shape)


@dataclass(frozen=True)
class Solved:
    command: Command
    qp: QuadraticProgram
    tick: Tick
    x: np.ndarray


@cache
def problem_of(controller: Controller) -> InverseDynamics:
    name = controller.format.robot
    return InverseDynamics(load_robot(FILES.get(name, name)))


def solve(controller: Controller, command: Command) -> Solved:
    problem = problem_of(controller)
    tick = Tick(controller.format, controller.run(command.request))
    wrenches = zip(problem.contacts, tick.wrenches.values(), strict=True)
    x = np.concatenate((tick.qdd, *[wrench[: contact.size] for contact, wrench in wrenches]))
    return Solved(command, problem.evaluate(command.request), tick, x)


# this module's are those of every robot, one after another
@pytest.fixture(scope="module")
def robot(any_robot: Robot) -> Robot:
    return any_robot


@pytest.fixture(scope="module")
def controller(any_controller: Controller) -> Controller:
    return any_controller


@pytest.fixture(scope="module")
def problem(controller: Controller) -> InverseDynamics:
    return problem_of(controller)


@pytest.fixture(scope="module")
def nominal(controller: Controller) -> list[Solved]:
    rng = np.random.default_rng(0)
    noise = [0.04, 0.2]  # the smaller one seldom reaches a limit
    return [
        solve(controller, random_command(problem_of(controller), rng, noise[i % 2]))
        for i in range(EACH)
    ]


@pytest.fixture(scope="module")
def drawn(controller: Controller) -> list[Solved]:
    rng = np.random.default_rng(1)
    found: list[Solved] = []
    while sum(is_stressed(solved) for solved in found) < EACH:
        command = random_command(problem_of(controller), rng)
        tighten(problem_of(controller), command, rng)
        found.append(solve(controller, command))
    return found


def is_stressed(solved: Solved) -> bool:
    return solved.tick.status == Status.OK and len(solved.tick.active) >= LEAST_ACTIVE


@pytest.fixture(scope="module")
def stressed(drawn: list[Solved]) -> list[Solved]:
    return [solved for solved in drawn if is_stressed(solved)]


@pytest.fixture(scope="module")
def one_foot_off(controller: Controller) -> list[Solved]:
    rng, contacts = np.random.default_rng(2), controller.format.contacts
    found = []
    for index in range(60):
        command = random_command(problem_of(controller), rng)
        command[f"{contacts[index % len(contacts)]}.active"] = 0.0
        if index % 3 == 0:
            command[f"{problem_of(controller).tasks[index % 2].name}.active"] = 0.0
        found.append(solve(controller, command))
    return found


@pytest.fixture(scope="module")
def blending(controller: Controller) -> list[Solved]:
    """Tasks on their way in or out, some with equal levels, masks and full gains."""
    rng, tasks = np.random.default_rng(12), problem_of(controller).tasks
    found = []
    for _ in range(40):
        command = random_command(problem_of(controller), rng)
        for task in tasks:
            command[f"{task.name}.active"] = rng.choice([0.0, 1e-6, 0.3, rng.random(), 1.0])
            command[f"{task.name}.mask"] = rng.choice([0.0, 0.5, 1.0], task.k, p=[0.2, 0.2, 0.6])
            for name in ("P", "D") if task.k > 1 else ():
                coupling = command[f"{task.name}.{name}_coupling"]
                coupling[:] = rng.uniform(-1, 1, coupling.size) * command[f"{task.name}.{name}"][0]
        found.append(solve(controller, command))
    return found


@pytest.fixture(scope="module")
def solutions(
    nominal: list[Solved],
    stressed: list[Solved],
    one_foot_off: list[Solved],
    blending: list[Solved],
) -> list[Solved]:
    # where a joint's limits yield it is another problem: test_yielding.py
    every = (*nominal, *stressed, *one_foot_off, *blending)
    found = [solved for solved in every if not solved.tick.yielded]
    assert len(found) > 2 * EACH
    return found


def test_states_are_solved_and_half_of_them_are_stressed(
    problem: InverseDynamics,
    nominal: list[Solved],
    drawn: list[Solved],
    one_foot_off: list[Solved],
) -> None:
    for name, group in (("nominal", nominal), ("stressed", drawn), ("one foot off", one_foot_off)):
        print(name, Counter(solved.tick.status.name for solved in group))
        print("  active", sorted(Counter(len(solved.tick.active) for solved in group).items()))
    assert all(solved.tick.status == Status.OK for solved in (*nominal, *one_foot_off))
    assert sum(solved.tick.active == [] for solved in nominal) > EACH / 4
    assert {s.tick.status for s in drawn} <= {Status.OK, Status.INFEASIBLE}
    kinds = Counter(kind_of(problem, row) for solved in drawn for row in solved.tick.active)
    print(kinds)
    inequalities = problem.row_names[problem.nv + problem.n_equalities :]
    every = {kind_of(problem, row) for row in inequalities} | {"joint_acceleration"}
    assert every >= {"friction", "unilateral_force", "joint_torque"}
    # the rarest, a foot that would lift, in one state of 25
    assert min(kinds[kind] for kind in every) > EACH / 25


def kind_of(problem: InverseDynamics, row: str) -> str:
    contacts = [contact.name for contact in problem.contacts]
    return next(part for part in row.split(".") if part not in contacts)


def second_solver(problem: InverseDynamics, qp: QuadraticProgram) -> np.ndarray:
    nv, meq = problem.nv, problem.n_equalities
    A = np.vstack((qp.A, np.eye(nv, problem.nx)))
    lower = np.concatenate((qp.lower[nv:], qp.lower[:nv]))
    upper = np.concatenate((qp.upper[nv:], qp.upper[:nv]))
    # a switched off foot: its wrench is held at zero, where its cone begins
    held = [int(np.flatnonzero(row)[0]) for row in A[:meq] if np.count_nonzero(row) == 1]
    free = np.delete(A[meq:], held, axis=1).any(axis=1)
    below, above = free & (lower[meq:] > -1e29), free & (upper[meq:] < 1e29)
    C = np.vstack((A[:meq], A[meq:][below], -A[meq:][above]))
    b = np.concatenate((lower[:meq], lower[meq:][below], -upper[meq:][above]))
    # variables of one size: quadprog's tolerances are absolute
    scale = 1 / np.sqrt(np.diag(qp.H))
    norms = np.maximum(np.linalg.norm(C * scale, axis=1), 1e-12)
    solution = quadprog.solve_qp(
        qp.H * scale * scale[:, None], -qp.g * scale, (C * scale).T / norms, b / norms, meq
    )
    return np.asarray(solution[0] * scale)


def torque(problem: InverseDynamics, solved: Solved, x: np.ndarray) -> np.ndarray:
    h_a = np.array(problem.qp(solved.command.request)[5])[:, 0]
    return np.asarray(solved.qp.A[-problem.n :] @ x + h_a)


def assert_same(problem: InverseDynamics, solved: Solved, x: np.ndarray, tolerance: float) -> None:
    nv, found = problem.nv, solved.x
    for part, expected in (
        (found[:nv], x[:nv]),
        (found[nv:], x[nv:]),
        (solved.tick.tau, torque(problem, solved, x)),
    ):
        scale = 1 + np.abs(expected).max()
        np.testing.assert_allclose(part, expected, rtol=0, atol=tolerance * scale)


def test_second_solver_finds_the_same_solution(
    problem: InverseDynamics, solutions: list[Solved]
) -> None:
    for solved in solutions:
        assert_same(problem, solved, second_solver(problem, solved.qp), 1e-6)


def test_second_solver_agrees_on_what_is_infeasible(controller: Controller) -> None:
    rng = np.random.default_rng(3)
    statuses = Counter[Status]()
    for _ in range(100):
        command = random_command(problem_of(controller), rng)
        tighten(problem_of(controller), command, rng, share=WEAK[controller.format.robot])
        solved = solve(controller, command)
        statuses[solved.tick.status] += 1
        if solved.tick.yielded:
            continue
        if solved.tick.status == Status.OK:
            second_solver(problem_of(controller), solved.qp)
        else:
            with pytest.raises(ValueError, match="inconsistent"):
                second_solver(problem_of(controller), solved.qp)
    print(statuses)
    assert set(statuses) == {Status.OK, Status.INFEASIBLE}
    assert min(statuses.values()) > 20


def test_reported_active_rows_give_the_optimum(
    problem: InverseDynamics, solutions: list[Solved]
) -> None:
    nv, nx, meq = problem.nv, problem.nx, problem.n_equalities
    for solved in solutions:
        qp, state = solved.qp, solved.tick.reply[problem.format.reply.slice("active")]
        np.testing.assert_array_equal(state[nv : nv + meq], 2.0)
        A = np.vstack((np.eye(nv, nx), qp.A))
        # a joint that is past a limit now may be at none of its bounds, or at any
        past = np.isin(np.abs(state), (RowState.PAST_POSITION, RowState.PAST_VELOCITY))
        values = np.concatenate((solved.x[:nv], qp.A @ solved.x))
        below, above = np.abs(values - qp.lower) < 1e-9, np.abs(values - qp.upper) < 1e-9
        state = np.where(past, above * 1.0 - below, state)
        rows = np.flatnonzero(state)
        target = np.where(state > 0, qp.upper, qp.lower)[rows]
        kkt = np.block([[qp.H, A[rows].T], [A[rows], np.zeros((len(rows), len(rows)))]])
        scale = 1 / np.sqrt(np.maximum(np.abs(kkt).max(axis=0), 1e-12))
        both = np.linalg.lstsq(
            kkt * scale * scale[:, None], np.concatenate((-qp.g, target)) * scale, rcond=1e-14
        )
        x, multipliers = np.split(both[0] * scale, [nx])
        assert_same(problem, solved, x, 1e-7)
        # a joint that must brake at all it may has one value left
        pushing = (state[rows] != 2) & ((qp.upper - qp.lower)[rows] > 1e-9)
        assert (np.sign(state[rows][pushing]) * multipliers[pushing] >= -1e-7).all()


def test_solutions_keep_every_row(problem: InverseDynamics, solutions: list[Solved]) -> None:
    for solved in solutions:
        values = np.concatenate((solved.x[: problem.nv], solved.qp.A @ solved.x))
        excess = np.maximum(solved.qp.lower - values, values - solved.qp.upper)
        worst = int(excess.argmax())
        assert excess[worst] < 1e-6, problem.format.row_names[worst]


def test_torque_stays_inside_its_limits(solutions: list[Solved]) -> None:
    for solved in solutions:
        assert (np.abs(solved.tick.tau) <= solved.command["limits.torque"] + 1e-6).all()


# The same problem again, from the paper's equations with numeric Pinocchio.


class Numeric:
    def __init__(self, robot: Robot, command: Command) -> None:
        self.robot, self.command, model = robot, command, robot.model
        self.model = model
        self.q, self.v = command["q"], command["v"]
        self.data = model.createData()
        zero = np.zeros(model.nv)
        upper = np.triu(pinocchio.crba(model, self.data, self.q))
        self.M = upper + np.triu(upper, 1).T
        self.h = np.array(pinocchio.nonLinearEffects(model, self.data, self.q, self.v))
        self.J_com = np.array(pinocchio.jacobianCenterOfMass(model, self.data, self.q))
        pinocchio.centerOfMass(model, self.data, self.q, self.v, zero)
        self.com = np.array(self.data.com[0])
        self.drift_com = np.array(self.data.acom[0])
        pinocchio.computeJointJacobians(model, self.data, self.q)
        pinocchio.forwardKinematics(model, self.data, self.q, self.v, zero)
        pinocchio.updateFramePlacements(model, self.data)

    def frame(self, part: Any, axes: Any) -> tuple[Any, np.ndarray, np.ndarray]:
        frame = self.robot.frame_id(part.name)
        drift = pinocchio.getFrameClassicalAcceleration(self.model, self.data, frame, axes)
        J = pinocchio.getFrameJacobian(self.model, self.data, frame, axes)
        return self.data.oMf[frame], np.array(J), np.array(drift.vector)

    def contacts(self) -> list[tuple[Any, np.ndarray, np.ndarray, bool]]:
        found = []
        for contact in self.robot.description.contacts:
            sole = contact.type == "sole"
            axes = pinocchio.LOCAL if sole else pinocchio.LOCAL_WORLD_ALIGNED
            _, J, drift = self.frame(contact, axes)
            k = 6 if sole else 3
            found.append((contact, J[:k], drift[:k], self.is_active(contact.name)))
        return found

    def is_active(self, name: str) -> bool:
        return bool(self.command[f"{name}.active"][0])

    @property
    def contact_jacobian(self) -> np.ndarray:
        return np.vstack([J for _, J, _, _ in self.contacts()])

    def task(self, task: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        reference = self.command[f"{task.name}.reference"]
        if task.type == "com":
            rows = [COM_AXES.index(axis) for axis in task.axes]
            J, drift, error = self.J_com, self.drift_com, reference - self.com
        else:
            rows = [FRAME_AXES.index(axis) for axis in task.axes]
            placement, J, drift = self.frame(task, pinocchio.LOCAL_WORLD_ALIGNED)
            away = (
                Rotation.from_quat(reference[3:]) * Rotation.from_matrix(placement.rotation).inv()
            )
            error = np.concatenate((reference[:3] - placement.translation, away.as_rotvec()))
        return J[rows], drift[rows], error[rows]

    def feedback(self, task: Any) -> np.ndarray:
        J, _, error = self.task(task)
        rate = self.command[f"{task.name}.reference_velocity"] - J @ self.v
        return np.asarray(self.gain(task, "P") @ error + self.gain(task, "D") @ rate)

    def gain(self, task: Any, name: str) -> np.ndarray:
        gain = np.diag(self.command[f"{task.name}.{name}"])
        if len(gain) > 1:
            below = np.zeros_like(gain)
            below[np.tril_indices(len(gain), -1)] = self.command[f"{task.name}.{name}_coupling"]
            gain = gain + below + below.T
        return gain

    def level(self, task: Any) -> np.ndarray:
        return np.asarray(self.command[f"{task.name}.active"] * self.command[f"{task.name}.mask"])

    def levels(self) -> list[tuple[float, np.ndarray]]:
        """Every row with its level."""
        tasks = self.robot.description.tasks
        rows = [(s, j) for t in tasks for s, j in zip(self.level(t), self.task(t)[0], strict=True)]
        return rows + [(float(active), j) for _, J, _, active in self.contacts() for j in J]

    def stacked(self) -> list[np.ndarray]:
        return [j for s, j in self.levels() if s > 0]

    def null_space(self) -> np.ndarray:
        # the mean over all thresholds of the projection past the rows above
        found, below = np.zeros((self.model.nv, self.model.nv)), 0.0
        for threshold in sorted({0.0, 1.0, *(s for s, _ in self.levels())})[1:]:
            there = [j for s, j in self.levels() if s >= threshold]
            found += (threshold - below) * self.past(there)
            below = threshold
        return found

    def past(self, rows: list[np.ndarray]) -> np.ndarray:
        if not rows:
            return np.eye(self.model.nv)
        _, s, Vt = np.linalg.svd(np.vstack(rows), full_matrices=False)
        return np.eye(self.model.nv) - Vt.T @ np.diag(s**2 / (s**2 + 1e-8)) @ Vt

    def weight(self, task: Any) -> np.ndarray:
        """The weight in series with the posture's, as far as the task is not there."""
        level = self.level(task)
        W = np.zeros((len(level), len(level)))
        W[np.tril_indices(len(level))] = self.command[f"{task.name}.W"]
        W = np.tril(W) + np.tril(W, -1).T
        rest = self.command["posture.W"].mean() + self.command["regularization.acceleration"][0]
        f = np.zeros(len(level))
        there = level > 0
        s, own = level[there], np.diag(W)[there]
        f[there] = 1 / (1 / own + (1 - s) / (s * rest)) / own
        return np.asarray(np.sqrt(np.outer(f, f)) * W)

    def cost(self) -> tuple[np.ndarray, np.ndarray]:
        command, nv = self.command, self.model.nv
        H, g = command["regularization.acceleration"] * np.eye(nv), np.zeros(nv)
        for task in self.robot.description.tasks:
            J, drift, _ = self.task(task)
            W = self.weight(task)
            desired = (
                command[f"{task.name}.reference_acceleration"]
                + command[f"{task.name}.feedforward"]
                + self.feedback(task)
            )
            H = H + J.T @ W @ J
            g = g + J.T @ W @ (drift - desired)
        N, W_q = self.null_space(), np.diag(command["posture.W"])
        qdd_des = np.zeros(nv)
        qdd_des[6:] = command["posture.P"] * (command["posture.q_ref"] - self.q[7:])
        qdd_des[6:] -= command["posture.D"] * self.v[6:]
        H = H + N.T @ W_q @ N
        g = g - N.T @ W_q @ N @ qdd_des
        contacts = [contact.name for contact in self.robot.description.contacts]
        W_lambda = np.concatenate([command[f"{name}.W_lambda"] for name in contacts])
        active = np.array([float(command[f"{name}.active"][0]) for name in contacts])
        each = [command[f"{name}.lambda_des"] for name in contacts]
        # those that stand take over what the others carried
        weight = np.array([forces[2] for forces in each])
        more = weight.sum() / (weight @ active) if active.any() else 0.0
        wanted = np.concatenate([a * more * forces for a, forces in zip(active, each, strict=True)])
        W_lambda *= 1 / np.maximum(np.repeat(active, [len(forces) for forces in each]), 1e-3)
        whole = np.zeros((nv + len(wanted), nv + len(wanted)))
        whole[:nv, :nv] = H
        whole[nv:, nv:] = np.diag(W_lambda)
        return whole, np.concatenate((g, -W_lambda * wanted))

    def acceleration_bounds(self, i: int) -> tuple[float, float]:
        def read(name: str) -> float:
            return float(self.command[f"limits.{name}"][i])

        T, limit = float(self.command["period"][0]), read("acceleration")
        q, v = float(self.q[7 + i]), float(self.v[6 + i])
        b = min(read("braking"), limit)
        low, high = read("position_lower"), read("position_upper")
        margin = min(0.75 * b * T**2, 0.1 * (high - low))
        most = []
        for way, speed in ((high - margin - q, v), (q - low - margin, -v)):
            # T s + s^2 / 2 b = d, or back in 0.1 s
            s = -b * T + np.sqrt((b * T) ** 2 + 2 * b * max(way, 0.0))
            if way < 0:
                s = max(way / 0.1, min(speed, 0.0) - b * T)
            fastest = max(read("velocity"), speed - b * T)
            most.append((min(s, fastest) - speed) / T)
        upper = max(min(most[0], limit), -limit)
        return min(max(-most[1], -limit), upper), upper

    def torque_bounds(self, i: int) -> tuple[float, float]:
        limit, stall, no_load = (
            float(self.command[f"limits.{name}"][i])
            for name in ("torque", "stall_torque", "no_load_speed")
        )
        share = float(self.v[6 + i]) / no_load
        left = [min(limit, max(0.0, stall * (1 - way * share))) for way in (-1, 1)]
        return -left[0], left[1]

    def rows(self) -> dict[str, tuple[np.ndarray, float, float]]:
        robot, command, nv = self.robot, self.command, self.model.nv
        nx = nv + len(self.contact_jacobian)
        rows: dict[str, tuple[np.ndarray, float, float]] = {}

        def add(name: str, columns: dict[int, float], low: float, high: float) -> None:
            a = np.zeros(nx)
            for column, value in columns.items():
                a[column] = value
            rows[name] = (a, low, high)

        for i, axis in enumerate(FRAME_AXES):
            add(f"joint_acceleration.base.{axis}", {i: 1.0}, -1e30, 1e30)
        for i, joint in enumerate(robot.joint_names):
            add(f"joint_acceleration.{joint}", {6 + i: 1.0}, *self.acceleration_bounds(i))
        dynamics = np.hstack((self.M, -self.contact_jacobian.T))
        for i, axis in enumerate(FRAME_AXES):
            rows[f"unactuated_dynamics.{axis}"] = (dynamics[i], -self.h[i], -self.h[i])
        first = nv
        for contact, J, drift, active in self.contacts():
            for i, (axis, row) in enumerate(zip(FRAME_AXES, J, strict=False)):
                columns = dict(enumerate(row)) if active else {first + i: 1.0}
                value = -drift[i] if active else 0.0
                add(f"{contact.name}.acceleration.{axis}", columns, value, value)
            first += len(J)
        first = nv
        for contact, J, _, active in self.contacts():
            name, (fx, fy, fz, mx, my, mz) = contact.name, range(first, first + 6)
            first += len(J)
            side = command[f"{name}.friction"][0] / np.sqrt(2)
            faces: dict[str, dict[int, float]] = {
                "friction.-x": {fx: 1.0, fz: side},
                "friction.+x": {fx: -1.0, fz: side},
                "friction.-y": {fy: 1.0, fz: side},
                "friction.+y": {fy: -1.0, fz: side},
            }
            if contact.type == "sole":
                x_low, x_high, y_low, y_high = command[f"{name}.extents"]
                gamma = command[f"{name}.torsional_friction"][0]
                faces = {
                    "center_of_pressure.-x": {my: -1.0, fz: -x_low},
                    "center_of_pressure.+x": {my: 1.0, fz: x_high},
                    "center_of_pressure.-y": {mx: 1.0, fz: -y_low},
                    "center_of_pressure.+y": {mx: -1.0, fz: y_high},
                    **faces,
                    "normal_torque.-z": {mz: 1.0, fz: gamma},
                    "normal_torque.+z": {mz: -1.0, fz: gamma},
                }
            for row, columns in faces.items():
                add(f"{name}.{row}", columns, 0.0, 1e30)
            least = command[f"{name}.minimum_force"][0] if active else 0.0
            most = command[f"{name}.maximum_force"][0] if active else 1e30
            add(f"{name}.unilateral_force", {fz: 1.0}, least, most)
        for i, joint in enumerate(robot.joint_names):
            (low, high), h = self.torque_bounds(i), self.h[6 + i]
            rows[f"joint_torque.{joint}"] = (dynamics[6 + i], low - h, high - h)
        return rows


def close(found: np.ndarray, expected: np.ndarray, rounding: float = 0.0) -> None:
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * scale + rounding)


def test_data_against_an_independent_assembly(
    robot: Robot, problem: InverseDynamics, nominal: list[Solved], one_foot_off: list[Solved]
) -> None:
    nv = robot.nv
    for solved in (*nominal[:60], *one_foot_off[:30]):
        numeric, qp = Numeric(robot, solved.command), solved.qp
        H, g = numeric.cost()
        close(qp.H[:nv, :nv], H[:nv, :nv])
        close(qp.H[nv:, nv:], H[nv:, nv:])
        assert not qp.H[:nv, nv:].any()
        close(qp.g[:nv], g[:nv])
        close(qp.g[nv:], g[nv:])
        rows = numeric.rows()
        assert tuple(rows) == problem.format.row_names
        A = np.vstack((np.eye(nv, problem.nx), qp.A))
        for i, (a, low, high) in enumerate(rows.values()):
            close(A[i], a)
            assert qp.lower[i] == pytest.approx(low, rel=1e-8, abs=1e-8)
            assert qp.upper[i] == pytest.approx(high, rel=1e-8, abs=1e-8)


def test_stressed_data_against_an_independent_assembly(
    robot: Robot, problem: InverseDynamics, stressed: list[Solved]
) -> None:
    test_data_against_an_independent_assembly(robot, problem, stressed[:40], [])


def test_tasks_on_their_way_against_an_independent_assembly(
    robot: Robot, problem: InverseDynamics, blending: list[Solved]
) -> None:
    assert all(solved.tick.status == Status.OK for solved in blending)
    test_data_against_an_independent_assembly(robot, problem, blending, [])
    test_error_and_feedback_are_reported(robot, blending)


def test_error_and_feedback_are_reported(robot: Robot, nominal: list[Solved]) -> None:
    for solved in nominal[:40]:
        numeric = Numeric(robot, solved.command)
        tasks = robot.description.tasks
        errors = np.concatenate([numeric.task(task)[2] for task in tasks])
        feedback = np.concatenate([numeric.feedback(task) for task in tasks])
        np.testing.assert_allclose(solved.tick.error, errors, atol=1e-10)
        np.testing.assert_allclose(solved.tick.feedback, feedback, atol=1e-8)


def test_equation_of_motion_holds_in_every_row(robot: Robot, solutions: list[Solved]) -> None:
    for solved in solutions:
        numeric = Numeric(robot, solved.command)
        wrenches = solved.x[robot.nv :]
        left = numeric.M @ solved.tick.qdd + numeric.h
        right = numeric.contact_jacobian.T @ wrenches
        right[6:] += solved.tick.tau
        np.testing.assert_allclose(left, right, rtol=0, atol=1e-8 * (1 + np.abs(left).max()))


def test_contacts_do_not_accelerate(robot: Robot, solutions: list[Solved]) -> None:
    for solved in solutions:
        for _, J, drift, active in Numeric(robot, solved.command).contacts():
            if active:
                acceleration = J @ solved.tick.qdd + drift
                assert np.abs(acceleration).max() < 1e-8 * (1 + np.abs(solved.tick.qdd).max())


def test_a_switched_off_foot_carries_nothing(
    controller: Controller, robot: Robot, one_foot_off: list[Solved]
) -> None:
    contacts = controller.format.contacts
    mass, g = pinocchio.computeTotalMass(robot.model), robot.model.gravity.linear
    for index, solved in enumerate(one_foot_off):
        off = contacts[index % len(contacts)]
        assert np.abs(solved.tick.wrenches[off]).max() < 1e-9
        # Newton's law: the others carry all that there is to carry
        numeric, carried = Numeric(robot, solved.command), np.zeros(3)
        for contact in robot.description.contacts:
            placement = numeric.frame(contact, pinocchio.LOCAL)[0]
            axes = placement.rotation if contact.type == "sole" else np.eye(3)
            carried += axes @ solved.tick.wrenches[contact.name][:3]
        acceleration = numeric.J_com @ solved.tick.qdd + numeric.drift_com
        np.testing.assert_allclose(carried, mass * (acceleration - g), atol=1e-6)


def test_a_point_carries_no_moment(controller: Controller, solutions: list[Solved]) -> None:
    for contact in problem_of(controller).contacts:
        moments = np.array([s.tick.wrenches[contact.name][3:] for s in solutions])
        assert moments.any() == (contact.size == 6)


def test_the_force_of_a_point_has_its_normal_along_the_worlds(controller: Controller) -> None:
    # turned about a horizontal axis with the whole robot, a sole would press askew
    files = problem_of(controller).robot.description.contacts
    for contact, file in zip(problem_of(controller).contacts, files, strict=True):
        if contact.size == 3:
            command = controller.command()
            command["q"][3:7] = turned(command["q"][3:7], np.random.default_rng(11), 0.2)
            program = problem_of(controller).evaluate(command.request)
            names = problem_of(controller).format.row_names
            row = names.index(f"{contact.name}.unilateral_force") - problem_of(controller).nv
            data = Numeric(problem_of(controller).robot, command)
            _, J, _ = data.frame(file, pinocchio.LOCAL_WORLD_ALIGNED)
            # the force that the row bounds does the work of the world's z
            column = int(np.flatnonzero(program.A[row])[0])
            np.testing.assert_allclose(program.A[:6, column], -J[2, :6], atol=1e-12)


def test_all_feet_off_is_free_fall(controller: Controller, robot: Robot) -> None:
    command = controller.command()
    for name in controller.format.contacts:
        command[f"{name}.active"] = 0.0
    tick = solve(controller, command).tick
    assert tick.status == Status.OK
    assert np.abs(list(tick.wrenches.values())).max() < 1e-9
    data = robot.model.createData()
    qdd = pinocchio.aba(
        robot.model, data, robot.home.q, robot.home.v, np.concatenate((np.zeros(6), tick.tau))
    )
    np.testing.assert_allclose(tick.qdd, qdd, atol=1e-8)


def moved(reference: np.ndarray) -> np.ndarray:
    turn = Rotation.from_rotvec([0.3, 0.3, 0.3])
    if len(reference) == 7:
        turn = turn * Rotation.from_quat(reference[3:])
    return np.concatenate((reference[:3] + 0.3, turn.as_quat()))[: len(reference)]


def test_a_switched_off_task_does_not_matter(controller: Controller) -> None:
    rng = np.random.default_rng(5)
    for task in problem_of(controller).tasks:
        command = random_command(problem_of(controller), rng)
        command[f"{task.name}.active"] = 0.0
        before = solve(controller, command)
        command[f"{task.name}.reference"] = moved(command[f"{task.name}.reference"])
        command[f"{task.name}.feedforward"] += 5.0
        command[f"{task.name}.P"] *= 7.0
        command[f"{task.name}.W"] *= 3.0
        after = solve(controller, command)
        assert before.tick.status == after.tick.status == Status.OK
        np.testing.assert_allclose(after.tick.tau, before.tick.tau, atol=1e-9)
        assert np.abs(after.tick.error - before.tick.error).max() > 0.1


def test_switching_a_task_on_tracks_it(controller: Controller) -> None:
    rng = np.random.default_rng(6)
    command = random_command(problem_of(controller), rng)
    task = problem_of(controller).robot.axis_for("", "com", "z").split(".")[0]
    command[f"{task}.reference_acceleration"] += 1.0
    with_task = solve(controller, command).tick
    command[f"{task}.active"] = 0.0
    without = solve(controller, command).tick
    J = Numeric(problem_of(controller).robot, command).J_com
    assert (np.abs(J @ (with_task.qdd - without.qdd)) > 0.3).any()


@pytest.mark.parametrize("rows", [5, 21])
def test_null_space_projector_against_numpy(rows: int) -> None:
    J = np.random.default_rng(0).normal(size=(rows, 23))
    J[1] = 0.0  # switched off
    J[3] = J[2]  # dependent
    symbol, level = ca.MX.sym("J", rows, 23), np.ones(rows)
    level[1] = 0.0
    found = np.array(ca.Function("P", [symbol], [null_space_projector(symbol, level)])(J))
    _, s, Vt = np.linalg.svd(J, full_matrices=False)
    expected = np.eye(23) - Vt.T @ np.diag(s**2 / (s**2 + DAMPING)) @ Vt
    np.testing.assert_allclose(found, expected, atol=1e-6)
    np.testing.assert_allclose(found, found.T, atol=1e-12)
    independent = np.delete(J, (1, 3), axis=0)
    assert np.abs(found @ independent.T).max() < 1e-6


def test_posture_cost_against_dense_numpy(robot: Robot, controller: Controller) -> None:
    rng = np.random.default_rng(7)
    for _ in range(20):
        command = random_command(problem_of(controller), rng)
        with_posture = problem_of(controller).evaluate(command.request)
        W_q = np.diag(command["posture.W"])
        command["posture.W"] = 0.0
        without = problem_of(controller).evaluate(command.request)
        numeric = Numeric(robot, command)
        N = numeric.null_space()
        qdd_des = np.zeros(robot.nv)
        qdd_des[6:] = command["posture.P"] * (command["posture.q_ref"] - command["q"][7:])
        qdd_des[6:] -= command["posture.D"] * command["v"][6:]
        nv = robot.nv
        # where the tasks leave no freedom the share is of the size of rounding: of the
        # sum, and of P_null = I - ..., which a nearly straight knee makes worse
        s = np.linalg.svd(np.vstack(numeric.stacked()))[1]
        eps = 10 * float(np.finfo(float).eps)
        P_error = eps * s[0] ** 2 / (s[-1] ** 2 + DAMPING)
        H_error = 2 * np.abs(N).max() * W_q.max() * P_error
        close(
            (with_posture.H - without.H)[:nv, :nv],
            N.T @ W_q @ N,
            H_error + eps * np.abs(without.H).max(),
        )
        close(
            (with_posture.g - without.g)[:nv],
            -N.T @ W_q @ N @ qdd_des,
            H_error * np.abs(qdd_des).max() + eps * np.abs(without.g).max(),
        )


def test_posture_does_not_disturb_the_tasks(controller: Controller) -> None:
    rng = np.random.default_rng(8)
    for _ in range(20):
        command = random_command(problem_of(controller), rng)
        numeric = Numeric(problem_of(controller).robot, command)
        N = numeric.null_space()
        for task in problem_of(controller).robot.description.tasks:
            if numeric.is_active(task.name):
                assert np.abs(numeric.task(task)[0] @ N).max() < 1e-4
        assert np.abs(numeric.contact_jacobian @ N).max() < 1e-4


def test_standing_still_at_home_carries_the_weight(controller: Controller, robot: Robot) -> None:
    tick = controller.tick(robot.home, controller.command())
    assert (tick.status, tick.active) == (Status.OK, [])
    # a home that is written with four digits lets the feet press on each other a little
    assert sum(w[2] for w in tick.wrenches.values()) == pytest.approx(robot.weight, rel=1e-5)
    assert np.abs(tick.qdd).max() < 5e-3


def test_moving_the_whole_problem_changes_nothing(controller: Controller) -> None:
    rng = np.random.default_rng(9)
    command = random_command(problem_of(controller), rng)
    before = solve(controller, command).tick
    shift = np.array([3.0, -2.0, 1.0])
    command["q"][:3] += shift
    for name in names_of(problem_of(controller), ".reference"):
        command[name][:3] += shift
    after = solve(controller, command).tick
    np.testing.assert_allclose(after.tau, before.tau, atol=1e-7)


def test_names_of_rows_are_unique_and_counted(problem: InverseDynamics) -> None:
    names = problem.format.row_names
    assert len(set(names)) == len(names)
    equalities = names[problem.nv : problem.nv + problem.n_equalities]
    assert all("dynamics" in name or ".acceleration." in name for name in equalities)
    assert problem.task_names == [t.name for t in problem.robot.description.tasks]


def lively(controller: Controller) -> Command:
    command = random_command(problem_of(controller), np.random.default_rng(10), 0.05)
    robot = problem_of(controller).robot
    com, turning = (
        robot.axis_for("", kind, axis).split(".")[0]
        for kind, axis in (("com", "x"), ("frame", "rx"))
    )
    # on narrow feet one limit would push the centre of pressure against another
    for name in names_of(problem_of(controller), ".extents"):
        command[name] = np.copysign(np.maximum(np.abs(command[name]), 0.05), command[name])
    command[f"{com}.reference_acceleration"] = [0.3, 0.2, 0.5]
    command[f"{turning}.reference_acceleration"] = [0.5, 0.4, 0.3]
    return command


@pytest.mark.parametrize("quantity", ["torque", "acceleration"])
def test_each_joint_limit_alone_is_noticed(controller: Controller, quantity: str) -> None:
    free = solve(controller, lively(controller)).tick
    assert (free.status, free.active) == (Status.OK, [])
    values = free.tau if quantity == "torque" else free.qdd[6:]
    for index, joint in enumerate(controller.format.joints):
        command = lively(controller)
        command[f"limits.{quantity}"][index] = limit = 0.9 * abs(values[index])
        tick = solve(controller, command).tick
        found = (tick.tau if quantity == "torque" else tick.qdd[6:])[index]
        assert tick.status == Status.OK
        assert tick.active == [f"joint_{quantity}.{joint}"]
        assert found == pytest.approx(np.copysign(limit, values[index]), abs=1e-8)


def test_each_contact_row_alone_is_noticed(controller: Controller) -> None:
    free = solve(controller, lively(controller)).tick
    for name, (fx, fy, fz, mx, my, mz) in free.wrenches.items():
        axis, pull = max(("x", fx), ("y", fy), key=lambda pair: abs(pair[1]))
        ahead = -my / fz
        aside = mx / fz
        trials: list[tuple[str, Any, str]] = [
            ("minimum_force", fz + 1.0, "unilateral_force"),
            (
                "friction",
                0.99 * np.sqrt(2) * abs(pull) / fz,
                f"friction.{'+' if pull > 0 else '-'}{axis}",
            ),
        ]
        of_a_sole: list[tuple[str, Any, str]] = [
            ("torsional_friction", 0.9 * abs(mz) / fz, f"normal_torque.{'+' if mz > 0 else '-'}z"),
            ("extents", [-1, ahead - 1e-3, -1, 1], "center_of_pressure.+x"),
            ("extents", [ahead + 1e-3, 1, -1, 1], "center_of_pressure.-x"),
            ("extents", [-1, 1, -1, aside - 1e-3], "center_of_pressure.+y"),
            ("extents", [-1, 1, aside + 1e-3, 1], "center_of_pressure.-y"),
        ]
        if f"{name}.extents" in lively(controller).fields:
            trials += of_a_sole
        for field, value, row in trials:
            command = lively(controller)
            command[f"{name}.{field}"] = value
            tick = solve(controller, command).tick
            assert (tick.status, tick.active) == (Status.OK, [f"{name}.{row}"])
