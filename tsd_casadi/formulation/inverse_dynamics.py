r"""The task-space inverse dynamics QP, section III of the paper.

.. math::

    \min_{\ddot q, \lambda} \tfrac12 \Big(
        \sum_t \|\ddot x_t - \ddot x_{t,des}\|^2_{W_t}
        + \|P_{null} (\ddot q - \ddot q_{des})\|^2_{W_q}
        + \|\lambda - \lambda_{des}\|^2_{W_\lambda}
        + \epsilon \|\ddot q\|^2 \Big)

subject to the base's dynamics, the contacts' accelerations and the limits in
``constraints``. The last term, not in the paper, makes the Hessian positive
definite in the directions that only the contact rows determine.

This module is the definition of the controller; what is compiled to C is made
from the functions here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from tsd_casadi.constraints.contact_acceleration import contact_acceleration
from tsd_casadi.constraints.joint_acceleration import joint_acceleration
from tsd_casadi.constraints.joint_position import position_bounds
from tsd_casadi.constraints.joint_torque import joint_torque
from tsd_casadi.constraints.joint_velocity import velocity_bounds
from tsd_casadi.constraints.rows import AccelerationBounds, Rows, stack_rows
from tsd_casadi.constraints.torque_speed import TorqueBounds, torque_bounds
from tsd_casadi.costs.force_regularization import (
    fading_weight,
    force_cost,
    share_wanted_forces,
)
from tsd_casadi.costs.null_space_posture import (
    null_space_projector,
    posture_acceleration,
    posture_cost,
)
from tsd_casadi.dynamics.actuated_dynamics import actuated_dynamics
from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.dynamics.unactuated_dynamics import unactuated_dynamics
from tsd_casadi.formulation.contact import Contact
from tsd_casadi.formulation.make_contacts import make_contacts
from tsd_casadi.formulation.make_force_tasks import make_force_tasks
from tsd_casadi.formulation.quadratic_program import QuadraticProgram
from tsd_casadi.formulation.safe_torque import safe_torque
from tsd_casadi.formulation.tick_layouts import request_layout, tick_format
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_casadi.tasks.contact_force_task import ContactForceTask
from tsd_casadi.tasks.desired_acceleration import desired_acceleration
from tsd_casadi.tasks.make_tasks import make_tasks
from tsd_casadi.tasks.task import Task
from tsd_casadi.tick.layout import Layout


@dataclass(frozen=True)
class _ContactTerms:
    """The contacts' part of the problem."""

    J: ca.SX
    J_active: ca.SX
    J_loaded: ca.SX
    level: ca.SX
    selections: dict[str, ca.SX]
    equalities: list[Rows]
    inequalities: list[Rows]
    W_lambda: ca.SX
    lambda_des: ca.SX


@dataclass(frozen=True)
class _TaskCosts:
    """The tasks' part of the cost."""

    H: ca.SX
    g: ca.SX
    J_active: ca.SX
    level: ca.SX
    error: ca.SX
    feedback: ca.SX


class InverseDynamics:
    """The QP of one robot as CasADi functions of one request vector.

    Attributes:
        robot: The robot.
        tasks: The Cartesian tasks, in the order of error and feedback.
        contacts: The contacts, in the order of lambda and the wrenches.
        forces: The tasks of contact forces.
        n: Number of actuated joints.
        nv: Size of v and of qdd.
        nx: Number of variables, nv and the forces of all contacts.
        request: Layout of the request: q, v and the command's fields.
        format: What a tick's request and reply mean; its rows are nv simple
            bounds, equalities, cones, joint torques.
        n_equalities: Number of equality rows, right after the bounds.
        terms: Function request -> everything but the posture's share of the
            cost: H_qdd, H_lambda (a diagonal), g, A, lower, upper, h_a, error,
            feedback, J, level, W_q, qdd_des of the posture, and what velocity and
            position ask of the joints' accelerations.
        qp: Function request -> H, g, A, lower, upper, h_a, error, feedback and
            the bounds by velocity and position: the definition of the QP.
        safe_torque: Function request -> tau.
    """

    def __init__(self, robot: Robot) -> None:
        """Build the symbolic problem of a robot."""
        self.robot = robot
        self.n = robot.n
        self.nv = robot.nv
        self.contacts: list[Contact] = make_contacts(robot)
        self.nx = robot.nv + sum(contact.size for contact in self.contacts)
        self.tasks: list[Task] = make_tasks(robot)
        self.forces: list[ContactForceTask] = make_force_tasks(robot, self.contacts)
        self.request: Layout = request_layout(robot, self.tasks, self.contacts, self.forces)
        self._request = ca.SX.sym("request", self.request.size)
        self._dynamics = SymbolicDynamics(robot, self._read("q"), self._read("v"))
        self.terms, self.safe_torque = self._build()
        self.qp = self._add_posture()
        self.format = tick_format(robot, self.tasks, self.contacts, self.request, self.row_names)

    def __repr__(self) -> str:
        """Name the robot and the size of its problem."""
        return (
            f"<InverseDynamics of {self.robot.name}: {self.nx} variables, {len(self.row_names)} "
            f"rows, {self.n_equalities} of them equalities; tasks {', '.join(self.task_names)}>"
        )

    @property
    def task_names(self) -> list[str]:
        """Names of the Cartesian tasks."""
        return [task.name for task in self.tasks]

    def evaluate(self, request: Vector) -> QuadraticProgram:
        """Compute the QP's numbers, straight from the definition.

        Args:
            request: (request.size,).

        Returns:
            The QP, for inspection and for checks by another solver.
        """
        H, g, A, lower, upper = (np.array(part) for part in self.qp(request)[:5])
        return QuadraticProgram(H, g[:, 0], A, lower[:, 0], upper[:, 0])

    def _read_of(self, part: str) -> Callable[[str], ca.SX]:
        """Give the fields of one task or contact by name."""
        return lambda name: self._read(f"{part}.{name}")

    def _read(self, name: str) -> ca.SX:
        return self._request[self.request.slice(name)]

    def _build(self) -> tuple[ca.Function, ca.Function]:
        M, h = self._dynamics.mass_matrix(), self._dynamics.bias_forces()
        contacts = self._contact_terms()
        tasks = self._task_costs()

        A_tau, h_a = actuated_dynamics(M, h, contacts.J)
        joints = self.robot.joint_names
        limit = self._read("limits.acceleration")
        braking = ca.fmin(self._read("limits.braking"), limit)
        velocity, position = self._velocity_bounds(braking), self._position_bounds(braking)
        bounds = joint_acceleration(joints, limit, [velocity, position], self.nx)
        equalities = stack_rows([unactuated_dynamics(M, h, contacts.J), *contacts.equalities])
        allowed = self._torque_bounds()
        torques = joint_torque(joints, A_tau, h_a, allowed)
        rows = stack_rows([equalities, *contacts.inequalities, torques])
        self.row_names: tuple[str, ...] = (*bounds.names, *rows.names)
        self.n_equalities = len(equalities.names)

        qdd_des = posture_acceleration(
            self._read("posture.P"),
            self._read("posture.q_ref"),
            self._read("posture.D"),
            self._dynamics.q,
            self._dynamics.v,
        )
        H_lambda, g_lambda = self._force_costs(contacts)
        terms = self._function(
            "terms",
            {
                # symmetric: one half is computed, the other copied
                "H_qdd": ca.triu2symm(ca.triu(tasks.H)),
                "H_lambda": H_lambda,
                "g": ca.vertcat(tasks.g, g_lambda),
                "A": rows.A,
                "lower": ca.vertcat(bounds.lower, rows.lower),
                "upper": ca.vertcat(bounds.upper, rows.upper),
                "h_a": h_a,
                "error": tasks.error,
                "feedback": tasks.feedback,
                "J": ca.vertcat(tasks.J_active, contacts.J_active),
                "level": ca.vertcat(tasks.level, contacts.level),
                "W_q": self._read("posture.W"),
                "qdd_des": qdd_des,
                "velocity_lower": velocity.lower,
                "velocity_upper": velocity.upper,
                "position_lower": position.lower,
                "position_upper": position.upper,
            },
        )
        safe = safe_torque(
            self._dynamics.gravity_forces(),
            contacts.J_loaded,
            self._dynamics.v,
            self._read("safe_torque.D"),
            allowed,
        )
        return terms, self._function("safe_torque", {"tau": safe})

    def _torque_bounds(self) -> TorqueBounds:
        return torque_bounds(
            self._dynamics.v[6:],
            self._read("limits.torque"),
            self._read("limits.stall_torque"),
            self._read("limits.no_load_speed"),
        )

    def _velocity_bounds(self, braking: ca.SX) -> AccelerationBounds:
        return velocity_bounds(
            self._dynamics.v[6:],
            self._read("limits.velocity"),
            braking,
            self._read("period"),
            self._read("limits.velocity_active"),
        )

    def _position_bounds(self, braking: ca.SX) -> AccelerationBounds:
        return position_bounds(
            self._dynamics.q[7:],
            self._dynamics.v[6:],
            self._read("limits.position_lower"),
            self._read("limits.position_upper"),
            braking,
            self._read("period"),
            self._read("limits.position_active"),
        )

    def _contact_terms(self) -> _ContactTerms:
        J_all, J_active, J_loaded, level = [], [], [], []
        equalities, inequalities = [], []
        selections, forces = {}, ca.SX.eye(self.nx - self.nv)
        first = 0
        for contact in self.contacts:

            def read(name: str, prefix: str = contact.name) -> ca.SX:
                return self._read(f"{prefix}.{name}")

            selection = forces[first : first + contact.size, :]
            first += contact.size
            selections[contact.name] = selection
            active = read("active")
            J, drift = contact.kinematics(self._dynamics)
            J_all.append(J)
            standing = active > 0
            J_active.append(standing * J)
            J_loaded.append(ca.sqrt(active) * J)
            level.append(ca.repmat(active, contact.size, 1))
            equalities.append(contact_acceleration(contact.name, J, drift, standing, selection))
            inequalities += contact.cone(read, self.nv, selection)

        def read_all(name: str) -> list[ca.SX]:
            return [self._read(f"{contact.name}.{name}") for contact in self.contacts]

        shares = read_all("active")
        W_lambda = map(fading_weight, read_all("W_lambda"), shares)
        return _ContactTerms(
            J=ca.vertcat(*J_all),
            J_active=ca.vertcat(*J_active),
            J_loaded=ca.vertcat(*J_loaded),
            level=ca.vertcat(*level),
            selections=selections,
            equalities=equalities,
            inequalities=inequalities,
            W_lambda=ca.vertcat(*W_lambda),
            lambda_des=ca.vertcat(*share_wanted_forces(shares, read_all("lambda_des"))),
        )

    def _task_costs(self) -> _TaskCosts:
        H = self._read("regularization.acceleration") * ca.SX.eye(self.nv)
        g = ca.SX.zeros(self.nv)
        J_active, levels, errors, feedbacks = [], [], [], []
        rest = self._rest_weight()
        for task in self.tasks:
            read = self._read_of(task.name)
            terms = task.terms(self._dynamics, read)
            feedback = task.feedback(terms, read)
            xdd_des = desired_acceleration(
                read("reference_acceleration"), read("feedforward"), feedback
            )
            level = task.levels(read)
            weighted = terms.J.T @ task.weight(read, rest)
            H += weighted @ terms.J
            g -= weighted @ (xdd_des - terms.drift)
            J_active.append((level > 0) * terms.J)
            levels.append(level)
            errors.append(terms.error)
            feedbacks.append(feedback)
        return _TaskCosts(
            H, g, *(ca.vertcat(*each) for each in (J_active, levels, errors, feedbacks))
        )

    def _force_costs(self, contacts: _ContactTerms) -> tuple[ca.SX, ca.SX]:
        H, g = force_cost(contacts.W_lambda, contacts.lambda_des)
        for force in self.forces:
            selection = contacts.selections[force.contact]
            there = self._read(f"{force.contact}.active")
            terms = force.terms(self._read_of(force.name), selection, contacts.W_lambda, there)
            H, g = H + terms.H, g + terms.g
        return H, g

    def _rest_weight(self) -> ca.SX:
        """Write the weight of what takes over from a task: posture and regularisation."""
        posture = ca.sum1(self._read("posture.W")) / self.nv
        return posture + self._read("regularization.acceleration")

    @cached_property
    def task_weight(self) -> ca.Function:
        """Function request -> W_s, the tasks' weights as their levels leave them, (k, k)."""
        weights = [
            task.weight(self._read_of(task.name), self._rest_weight()) for task in self.tasks
        ]
        return self._function("task_weight", {"W": ca.diagcat(*weights)})

    def _function(self, name: str, outputs: dict[str, ca.SX]) -> ca.Function:
        dense = [ca.densify(value) for value in outputs.values()]
        return ca.Function(name, [self._request], dense, ["request"], list(outputs))

    def _add_posture(self) -> ca.Function:
        """Add the posture's share to the terms, which makes the whole QP.

        Written out in scalars, P_null would dwarf everything else; as a matrix
        expression it stays a solve and four products.
        """
        request = ca.MX.sym("request", self.request.size)
        names = [self.terms.name_out(i) for i in range(self.terms.n_out())]
        values = dict(zip(names, self.terms.call([request]), strict=True))
        P_null = null_space_projector(values.pop("J"), values.pop("level"))
        H, g = posture_cost(P_null, values.pop("W_q"), values.pop("qdd_des"))
        H_qdd, H_lambda = values.pop("H_qdd"), values.pop("H_lambda")
        outputs = {"H": ca.diagcat(H_qdd + H, ca.diag(H_lambda)), **values}
        outputs["g"] += ca.vertcat(g, ca.MX(self.nx - self.nv, 1))
        dense = [ca.densify(value) for value in outputs.values()]
        return ca.Function("qp", [request], dense, ["request"], list(outputs))
