"""The same QP from numeric Pinocchio, numpy and DAQP: what one would write by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import daqp
import numpy as np
import pinocchio

from tsd_casadi.constraints.joint_position import LARGEST_MARGIN, MARGIN, RETURN_TIME
from tsd_casadi.costs.null_space_posture import DAMPING
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.formulation.quadratic_program import QuadraticProgram
from tsd_casadi.robot.robot_file_sections import FRAME_AXES, PointFile, SoleFile
from tsd_casadi.state import Matrix, Vector

EQUALITY = 5  # DAQP: active and immutable
INFINITY = 1e30


@dataclass(frozen=True)
class NumericTick:
    """One solved tick.

    Attributes:
        tau: (n,) [N m].
        flag: DAQP's exit flag, 1 is optimal.
        times: Data, factorisation, solve [us].
    """

    tau: Vector
    flag: int
    times: tuple[float, float, float]


class NumericController:
    """Numeric Pinocchio for the dynamics, numpy for the rows, DAQP for the QP."""

    def __init__(self, problem: InverseDynamics) -> None:
        """Take robot, tasks and layout from a problem; none of its functions."""
        self._problem = problem
        self._model = problem.robot.model
        self._data = self._model.createData()
        self._contacts = problem.robot.description.contacts
        self._frames = {
            part.name: problem.robot.frame_id(part.name)
            for part in (*self._contacts, *problem.robot.description.tasks)
            if hasattr(part, "frame")
        }
        self._lower = np.tril_indices(problem.nv, -1)
        self._zero = np.zeros(problem.nv)
        self._sense = np.zeros(len(problem.row_names), dtype=np.int32)
        self._sense[problem.nv : problem.nv + problem.n_equalities] = EQUALITY

    def tick(self, request: Vector) -> NumericTick:
        """Solve one tick.

        Args:
            request: (request.size,).
        """
        start = perf_counter()
        program, h_a = self.assemble(request)
        data_time = perf_counter() - start
        start = perf_counter()
        x, _, flag, info = daqp.solve(
            program.H,
            program.g,
            program.A,
            program.upper,
            program.lower,
            self._sense,
            primal_tol=1e-9,
        )
        solver_time = perf_counter() - start
        n = self._problem.n
        tau = program.A[-n:] @ x + h_a
        factorization = min(info["setup_time"], solver_time)
        times = (data_time, factorization, solver_time - factorization)
        return NumericTick(tau, flag, tuple(1e6 * t for t in times))  # type: ignore[arg-type]

    def assemble(self, request: Vector) -> tuple[QuadraticProgram, Vector]:
        """Compute the QP's numbers.

        Args:
            request: (request.size,).

        Returns:
            The QP and h_a (n,) [N m].
        """
        problem, model, data = self._problem, self._model, self._data
        layout = problem.request.slices
        nv, nx = problem.nv, problem.nx

        def read(name: str) -> Vector:
            return request[layout[name]]

        q, v = read("q"), read("v")
        M = pinocchio.crba(model, data, q)
        M[self._lower] = M.T[self._lower]
        h = pinocchio.nonLinearEffects(model, data, q, v)
        J_com = pinocchio.jacobianCenterOfMass(model, data, q)
        pinocchio.computeJointJacobians(model, data, q)
        # this computes velocities and, with no acceleration, drifts as well
        pinocchio.centerOfMass(model, data, q, v, self._zero)
        pinocchio.updateFramePlacements(model, data)

        # contacts
        J_all, J_active, rows, lower, upper = [], [], [], [], []
        columns: dict[str, slice] = {}
        first = nv
        for contact in self._contacts:
            frame = self._frames[contact.name]
            is_sole = contact.type == "sole"
            axes = pinocchio.LOCAL if is_sole else pinocchio.LOCAL_WORLD_ALIGNED
            size = 6 if is_sole else 3
            J = pinocchio.getFrameJacobian(model, data, frame, axes)[:size]
            drift = pinocchio.getFrameClassicalAcceleration(model, data, frame, axes)
            drift = drift.vector[:size]
            active = read(f"{contact.name}.active")[0]
            columns[contact.name] = slice(first, first + size)
            first += size
            row = np.zeros((size, nx))
            row[:, :nv] = active * J
            row[:, columns[contact.name]] = (1 - active) * np.eye(size)
            rows.append(row)
            lower.append(-active * drift)
            upper.append(-active * drift)
            J_all.append(J)
            J_active.append(active * J)
        J_c = np.vstack(J_all)
        dynamics = np.hstack((M, -J_c.T))
        rows.insert(0, dynamics[:6])
        lower.insert(0, -h[:6])
        upper.insert(0, -h[:6])
        for contact in self._contacts:
            cone, low = self._cone(contact, read)
            row = np.zeros((len(cone), nx))
            row[:, columns[contact.name]] = cone
            rows.append(row)
            lower.append(low)
            upper.append(np.full(len(low), INFINITY))
        rows.append(dynamics[6:])
        share = v[6:] / read("limits.no_load_speed")
        for bounds, way in ((lower, -1), (upper, 1)):
            left = np.maximum(read("limits.stall_torque") * (1 - way * share), 0.0)
            bounds.append(way * np.minimum(read("limits.torque"), left) - h[6:])

        # cost
        H, g = np.zeros((nx, nx)), np.zeros(nx)
        H[range(nv), range(nv)] = read("regularization.acceleration")[0]
        J_tasks = []
        for task in problem.robot.description.tasks:
            prefix = task.name
            axes = ("x", "y", "z") if task.type == "com" else FRAME_AXES
            select = [axes.index(axis) for axis in task.axes]
            reference = read(f"{prefix}.reference")
            if task.type == "com":
                J, drift = J_com[select], data.acom[0][select]
                error = (reference - data.com[0])[select]
            else:
                frame = self._frames[task.name]
                world = pinocchio.LOCAL_WORLD_ALIGNED
                J = pinocchio.getFrameJacobian(model, data, frame, world)[select]
                drift = pinocchio.getFrameClassicalAcceleration(model, data, frame, world)
                drift = drift.vector[select]
                R_ref = pinocchio.Quaternion(reference[3:]).toRotationMatrix()
                placement = data.oMf[frame]
                turn = pinocchio.log3(R_ref @ placement.rotation.T)
                error = np.concatenate((reference[:3] - placement.translation, turn))[select]
            feedback = read(f"{prefix}.P") * error
            feedback += read(f"{prefix}.D") * (read(f"{prefix}.reference_velocity") - J @ v)
            desired = read(f"{prefix}.reference_acceleration") + read(f"{prefix}.feedforward")
            desired = desired + feedback
            W = np.zeros((len(select), len(select)))
            W[np.tril_indices(len(select))] = read(f"{prefix}.W")
            W = W + np.tril(W, -1).T
            active = read(f"{prefix}.active")[0]
            H[:nv, :nv] += active * J.T @ W @ J
            g[:nv] -= active * J.T @ W @ (desired - drift)
            J_tasks.append(active * J)
        J = np.vstack(J_tasks + J_active)
        P_null = np.eye(nv) - J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(len(J)), J)
        posture = P_null.T @ (read("posture.W")[:, None] * P_null)
        joints = read("posture.P") * (read("posture.q_ref") - q[7:]) - read("posture.D") * v[6:]
        H[:nv, :nv] += posture
        g[:nv] -= posture @ np.concatenate((np.zeros(6), joints))
        W_lambda = np.concatenate([read(f"{c.name}.W_lambda") for c in self._contacts])
        lambda_des = np.concatenate([read(f"{c.name}.lambda_des") for c in self._contacts])
        H[range(nv, nx), range(nv, nx)] = W_lambda
        g[nv:] = -W_lambda * lambda_des

        least, most = self._acceleration_bounds(q[7:], v[6:], read)
        base = np.full(6, INFINITY)
        program = QuadraticProgram(
            H,
            g,
            np.vstack(rows),
            np.concatenate([-base, least, *lower]),
            np.concatenate([base, most, *upper]),
        )
        return program, h[6:]

    @staticmethod
    def _acceleration_bounds(
        q: Vector, v: Vector, read: Callable[[str], Vector]
    ) -> tuple[Vector, Vector]:
        T, limit = read("period"), read("limits.acceleration")
        b = np.minimum(read("limits.braking"), limit)
        low, high = read("limits.position_lower"), read("limits.position_upper")
        margin = np.minimum(MARGIN * b * T**2, LARGEST_MARGIN * (high - low))
        bounds = []
        for way, speed in ((high - margin - q, v), (q - low - margin, -v)):
            inside, beyond = np.maximum(way, 0.0), np.minimum(way, 0.0)
            s = 2 * inside / (T + np.sqrt(T**2 + 2 * inside / b))
            s += np.maximum(beyond / RETURN_TIME, np.minimum(speed, 0.0) - b * T)
            fastest = np.maximum(read("limits.velocity"), speed - b * T)
            bounds.append((np.minimum(s, fastest) - speed) / T)
        upper = np.clip(bounds[0], -limit, limit)
        return np.minimum(np.maximum(-bounds[1], -limit), upper), upper

    @staticmethod
    def _cone(
        contact: SoleFile | PointFile, read: Callable[[str], Vector]
    ) -> tuple[Matrix, Vector]:
        name = contact.name
        mu = read(f"{name}.friction")[0] / np.sqrt(2)
        slide = np.zeros((4, 6))
        slide[:, 2] = mu
        slide[0, 0], slide[1, 0], slide[2, 1], slide[3, 1] = 1, -1, 1, -1
        push = np.eye(1, 6, 2)
        if contact.type == "sole":
            x_low, x_high, y_low, y_high = read(f"{name}.extents")
            gamma = read(f"{name}.torsional_friction")[0]
            press, twist = np.zeros((4, 6)), np.zeros((2, 6))
            press[:, 2] = (-x_low, x_high, -y_low, y_high)
            press[0, 4], press[1, 4], press[2, 3], press[3, 3] = -1, 1, 1, -1
            twist[:, 2], twist[0, 5], twist[1, 5] = gamma, 1, -1
            cone = np.vstack((press, slide, twist, push, -push))
        else:
            cone = np.vstack((slide, push, -push))[:, :3]
        low = np.zeros(len(cone))
        active = read(f"{name}.active")[0]
        low[-2] = active * read(f"{name}.minimum_force")[0]
        low[-1] = -active * read(f"{name}.maximum_force")[0]
        return cone, low
