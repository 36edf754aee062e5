from __future__ import annotations

import casadi as ca
import numpy as np
import pinocchio
import pytest

from tsd_casadi import Robot
from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.tasks.com_task import ComTask
from tsd_clients.simulator.parity import random_state

STEP = 1e-6


def terms_function(robot: Robot, axes: tuple[str, ...]) -> ca.Function:
    q, v = ca.SX.sym("q", robot.nq), ca.SX.sym("v", robot.nv)
    task = ComTask("task", axes, 1.0, 2.0, 3.0)
    command = {
        "reference": ca.SX.sym("reference", 3),
        "reference_velocity": ca.SX.sym("reference_velocity", task.k),
    }
    terms = task.terms(SymbolicDynamics(robot, q, v), lambda name: command[name])
    outputs = [terms.J, terms.drift, terms.error, terms.error_rate]
    return ca.Function("terms", [q, v, *command.values()], outputs)


def com(robot: Robot, q: np.ndarray) -> np.ndarray:
    return np.array(pinocchio.centerOfMass(robot.model, robot.model.createData(), q))


@pytest.mark.parametrize("axes", [("x", "y", "z"), ("z",), ("y", "x")], ids="".join)
def test_terms_against_finite_differences(robot: Robot, axes: tuple[str, ...]) -> None:
    terms = terms_function(robot, axes)
    rows = ["xyz".index(axis) for axis in axes]
    rng = np.random.default_rng(0)
    for _ in range(5):
        state = random_state(robot, rng)
        reference, reference_velocity = rng.normal(size=3), rng.normal(size=len(axes))
        J, drift, error, error_rate = (
            np.array(part) for part in terms(state.q, state.v, reference, reference_velocity)
        )
        ahead, behind = (
            com(robot, pinocchio.integrate(robot.model, state.q, sign * STEP * state.v))
            for sign in (1, -1)
        )
        here = com(robot, state.q)
        velocity = ((ahead - behind) / (2 * STEP))[rows]
        np.testing.assert_allclose(error[:, 0], (reference - here)[rows], atol=1e-12)
        np.testing.assert_allclose(J @ state.v, velocity, atol=1e-7)
        np.testing.assert_allclose(error_rate[:, 0], reference_velocity - velocity, atol=1e-7)
        far = 1e-3
        ahead, behind = (
            com(robot, pinocchio.integrate(robot.model, state.q, sign * far * state.v))
            for sign in (1, -1)
        )
        acceleration = ((ahead - 2 * here + behind) / far**2)[rows]
        np.testing.assert_allclose(drift[:, 0], acceleration, atol=1e-3)


def test_reference_defaults_to_home(robot: Robot) -> None:
    field = ComTask("task", ("z",), 1.0, 2.0, 3.0).reference_fields(robot)[0]
    np.testing.assert_allclose(field.default, com(robot, robot.home.q), atol=1e-12)
    assert (field.name, field.size, field.unit) == ("task.reference", 3, "m")


def test_fields_have_one_value_per_controlled_axis(robot: Robot) -> None:
    fields = {f.name: f for f in ComTask("task", ("z", "x"), 1.0, 2.0, 3.0).fields(robot)}
    assert {f"task.{name}": fields[f"task.{name}"].size for name in ("P", "D", "W")} == {
        "task.P": 2,
        "task.D": 2,
        "task.W": 3,
    }
    assert fields["task.P"].default == (1.0, 1.0)
    assert fields["task.D"].default == (2.0, 2.0)
    assert fields["task.W"].default == (3.0, 0.0, 3.0)
    for name in ("active", "mask"):
        assert not fields[f"task.{name}"].switch
        assert (fields[f"task.{name}"].lower, fields[f"task.{name}"].upper) == (0.0, 1.0)
