"""Explain one request from the definition of its QP, which takes milliseconds."""

from __future__ import annotations

import numpy as np

from tsd_casadi.explanation.conflict import Conflict, find_conflict
from tsd_casadi.explanation.explanation import ConflictingRow, Explanation, LimitCost
from tsd_casadi.explanation.reduced_rows import ReducedRows, reduce_rows
from tsd_casadi.explanation.task_costs import TaskCosts, find_task_costs
from tsd_casadi.formulation.dependent_rows import add_partly_held
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.formulation.quadratic_program import QuadraticProgram
from tsd_casadi.state import Matrix, Vector


def explain(problem: InverseDynamics, request: Vector) -> Explanation:
    """Say why a request has no solution, or what its limits cost the tasks.

    Args:
        request: (request.size,), state and command, as ``Command.request``.

    Raises:
        numpy.linalg.LinAlgError: If a weight is zero or negative where the solution
            needs it.
    """
    program = problem.evaluate(request)
    reduced = reduce_rows(program, problem.nv, problem.n_equalities)
    conflict = find_conflict(reduced)
    if conflict is not None:
        # limits of joint positions and velocities yield before anything is infeasible
        request = _without_yielding_limits(problem, request)
        program = problem.evaluate(request)
        reduced = reduce_rows(program, problem.nv, problem.n_equalities)
        conflict = find_conflict(reduced)
    bounds = _bounds(problem, request, program, reduced)
    if conflict is not None:
        rows = _conflicting_rows(problem, reduced, bounds, conflict)
        return Explanation(False, dependent=reduced.held.dependent, conflict=rows)
    J, wanted = _tasks(problem, request)
    costs = find_task_costs(add_partly_held(program, reduced.held), reduced, J, wanted)
    # no conflict was found above
    assert costs is not None
    return Explanation(
        True,
        dependent=reduced.held.dependent,
        limits=_limit_costs(problem, reduced, bounds, costs),
        otherwise=_by_axis(problem, costs.otherwise),
    )


def _without_yielding_limits(problem: InverseDynamics, request: Vector) -> Vector:
    changed = request.copy()
    for name in ("limits.position_active", "limits.velocity_active"):
        changed[problem.request.slice(name)] = 0.0
    return changed


def _bounds(
    problem: InverseDynamics, request: Vector, program: QuadraticProgram, reduced: ReducedRows
) -> Vector:
    """Bounds of the reduced rows in their own units; those of torques without h_a."""
    offset = np.zeros(len(program.lower))
    offset[-problem.n :] = np.array(problem.qp(request)[problem.qp.index_out("h_a")])[:, 0]
    bound = np.where(reduced.sides > 0, program.upper[reduced.rows], program.lower[reduced.rows])
    return np.asarray(bound + offset[reduced.rows])


def _tasks(problem: InverseDynamics, request: Vector) -> tuple[Matrix, Vector]:
    """Stacked task Jacobians and what J qdd should be, read back from the cost's terms.

    The gradient of their cost is -J^T W wanted; of an axis without weight, or of a
    dependent one, nothing is known and the smallest number is taken.
    """
    values = dict(zip(problem.terms.name_out(), problem.terms(request), strict=True))
    W = np.array(problem.task_weight(request))
    J = np.array(values["J"])[: len(W)]
    gradient = np.array(values["g"])[: problem.nv, 0]
    wanted = np.linalg.lstsq(J.T @ W, -gradient, rcond=None)[0]
    return J, np.asarray(wanted, dtype=float)


def _conflicting_rows(
    problem: InverseDynamics, reduced: ReducedRows, bounds: Vector, conflict: Conflict
) -> tuple[ConflictingRow, ...]:
    return tuple(
        ConflictingRow(
            name=problem.row_names[reduced.rows[place]],
            side=_side(reduced, place),
            bound=float(bounds[place]),
            violation=float(violation),
            alone=float(alone),
        )
        for place, violation, alone in zip(
            conflict.places, conflict.violations, conflict.alone, strict=True
        )
    )


def _limit_costs(
    problem: InverseDynamics, reduced: ReducedRows, bounds: Vector, costs: TaskCosts
) -> tuple[LimitCost, ...]:
    limits = [
        LimitCost(
            name=problem.row_names[reduced.rows[place]],
            side=_side(reduced, place),
            bound=float(bounds[place]),
            multiplier=float(multiplier),
            tasks=_by_axis(problem, lost),
        )
        for place, multiplier, lost in zip(
            costs.active, costs.multipliers, costs.by_limit, strict=True
        )
    ]
    return tuple(sorted(limits, key=lambda limit: -max(map(abs, limit.tasks.values()))))


def _by_axis(problem: InverseDynamics, values: Vector) -> dict[str, float]:
    names = [f"{task}.{axis}" for task, axis in problem.format.axes]
    return dict(zip(names, values.tolist(), strict=True))


def _side(reduced: ReducedRows, place: np.intp) -> str:
    return "upper" if reduced.sides[place] > 0 else "lower"
