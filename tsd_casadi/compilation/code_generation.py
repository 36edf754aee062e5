"""The C source of one problem: CasADi's functions and the sizes of the tick."""

from __future__ import annotations

import importlib.resources
from collections.abc import Mapping

import casadi as ca

from tsd_casadi.constraints.joint_acceleration import YIELDING_WEIGHT
from tsd_casadi.costs.null_space_posture import DAMPING
from tsd_casadi.formulation.contact import WRENCH
from tsd_casadi.formulation.dependent_rows import DEPENDENT, HOLDING_WEIGHT, INDEPENDENT
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.tick.layout import QUATERNION_TOLERANCE

# Bound of a row's violation, measured by DAQP in the metric of the cost, where
# light weights on forces make a newton small.
PRIMAL_TOLERANCE = 1e-10
# What a solution may violate a limit by, as a share of 1 + |limit|; more is told
# as a failure.
LIMIT_TOLERANCE = 1e-6
# Some 30 times what stressed states need.
ITERATION_LIMIT = 400
# What native/ reads of the request's limits.
LIMITS_READ = (
    "torque",
    "stall_torque",
    "no_load_speed",
    "acceleration",
    "velocity",
    "velocity_active",
    "position_lower",
    "position_upper",
    "position_active",
)
# The hand-written part, in native/.
NATIVE = (
    "dense.h",
    "tick.h",
    "posture.c",
    "elimination.c",
    "joint_limits.c",
    "conflict.c",
    "tick.c",
)


def generate_sources(problem: InverseDynamics) -> dict[str, str]:
    """Write a problem as C.

    Returns:
        Source text by file name: the generated functions (problem.c), sizes
        (problem.h) and the tick around them.
    """
    generator = ca.CodeGenerator("problem.c", {"with_header": False})
    generator.add(problem.terms)
    generator.add(problem.safe_torque)
    native = importlib.resources.files("tsd_casadi.compilation").joinpath("native")
    return {
        "problem.c": generator.dump(),
        "problem.h": _header(problem),
        **{name: native.joinpath(name).read_text() for name in NATIVE},
    }


def _header(problem: InverseDynamics) -> str:
    request, reply = problem.format.request, problem.format.reply
    sizes: dict[str, int | float] = {
        "N_REQUEST": request.size,
        "N_REPLY": reply.size,
        "N_X": problem.nx,
        "N_TAU": problem.n,
        "N_ERROR": len(problem.format.axes),
        "N_V": problem.nv,
        "N_WRENCHES": WRENCH * len(problem.contacts),
        "N_J": problem.terms.size1_out("J"),
        "N_GENERAL": len(problem.format.row_names) - problem.nv,
        "N_EQUALITIES": problem.n_equalities,
        "POSTURE_DAMPING": DAMPING,
        "DEPENDENT": DEPENDENT,
        "INDEPENDENT": INDEPENDENT,
        "HOLDING_WEIGHT": HOLDING_WEIGHT,
        "PRIMAL_TOLERANCE": PRIMAL_TOLERANCE,
        "LIMIT_TOLERANCE": LIMIT_TOLERANCE,
        "ITERATION_LIMIT": ITERATION_LIMIT,
        "YIELDING_WEIGHT": YIELDING_WEIGHT,
        "QUATERNION_TOLERANCE": QUATERNION_TOLERANCE,
    }
    sizes |= {
        f"REQUEST_{name.upper()}": request.slice(name).start for name in ("q", "v", "explain")
    }
    sizes |= {
        f"REQUEST_{name.upper()}": request.slice(f"limits.{name}").start for name in LIMITS_READ
    }
    sizes |= {f"REPLY_{part.name.upper()}": reply.slice(part.name).start for part in reply}
    sizes |= _work_sizes(problem)
    functions = "\n".join(
        f"int {name}(const double** arg, double** res, casadi_int* iw, double* w, int mem);"
        for name in ("terms", "safe_torque")
    )
    tables = {
        "switches": request.switches(),
        "quaternions": request.quaternions(),
        "force_places": _force_places(problem),
    }
    lines = ("#pragma once", "typedef long long int casadi_int;")
    return "\n".join((*lines, _defines(sizes), functions, _tables(tables)))


def _force_places(problem: InverseDynamics) -> list[int]:
    """List where in the reply's wrenches each of lambda goes; a point has no moments."""
    return [
        WRENCH * index + component
        for index, contact in enumerate(problem.contacts)
        for component in range(contact.size)
    ]


def _work_sizes(problem: InverseDynamics) -> dict[str, int]:
    functions = (problem.terms, problem.safe_torque)
    return {
        f"SZ_{part.upper()}": max(1, *(getattr(f, f"sz_{part}")() for f in functions))
        for part in ("arg", "res", "iw", "w")
    }


def _defines(sizes: Mapping[str, int | float]) -> str:
    return "\n".join(f"#define {name} {value}" for name, value in sizes.items())


def _tables(tables: Mapping[str, list[int]]) -> str:
    lines = []
    for name, values in tables.items():
        lines.append(f"#define N_{name.upper()} {len(values)}")
        # one more, because C has no empty arrays
        listed = ", ".join(map(str, [*values, 0]))
        lines.append(f"__attribute__((unused)) static const int {name}[] = {{{listed}}};")
    return "\n".join(lines) + "\n"
