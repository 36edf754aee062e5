"""The angular momentum's task against Pinocchio's centroidal dynamics."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pinocchio
import pytest

from tsd_casadi import Robot
from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.tasks.angular_momentum_task import AngularMomentumTask
from tsd_clients.simulator.parity import random_state

AXES = ("rx", "ry", "rz")


def make(robot: Robot, axes: tuple[str, ...]) -> AngularMomentumTask:
    return AngularMomentumTask("spin", axes, 5.0, 1.0, robot.home_inertia)


def terms_function(robot: Robot, axes: tuple[str, ...]) -> ca.Function:
    q, v = ca.SX.sym("q", robot.nq), ca.SX.sym("v", robot.nv)
    reference = ca.SX.sym("reference", len(axes))
    task = make(robot, axes)
    terms = task.terms(SymbolicDynamics(robot, q, v), lambda name: reference)
    return ca.Function("terms", [q, v, reference], [terms.J, terms.drift, terms.error])


@pytest.mark.parametrize("axes", [AXES, ("rz", "rx")], ids="".join)
def test_terms_against_pinocchio(any_robot: Robot, axes: tuple[str, ...]) -> None:
    robot, terms = any_robot, terms_function(any_robot, axes)
    rows = [AXES.index(axis) for axis in axes]
    rng, inertia = np.random.default_rng(0), robot.home_inertia
    for _ in range(5):
        state = random_state(robot, rng)
        reference, qdd = rng.normal(size=len(axes)), rng.normal(size=robot.nv)
        J, drift, error = (np.array(part) for part in terms(state.q, state.v, reference))
        data = robot.model.createData()
        A = pinocchio.computeCentroidalMap(robot.model, data, state.q)[3:][rows]
        np.testing.assert_allclose(J * inertia, A, atol=1e-9)
        np.testing.assert_allclose(error[:, 0], reference - A @ state.v / inertia, atol=1e-9)
        pinocchio.computeCentroidalMomentumTimeVariation(robot.model, data, state.q, state.v, qdd)
        rate = np.array(data.dhg.angular)[rows]
        np.testing.assert_allclose((J @ qdd + drift[:, 0]) * inertia, rate, atol=1e-7)


def test_it_has_damping_and_no_place_to_be_at(robot: Robot) -> None:
    fields = {field.name: field for field in make(robot, AXES).fields(robot)}
    assert "spin.reference" not in fields
    assert "spin.P" not in fields
    assert fields["spin.D"].default == (5.0,) * 3
    assert fields["spin.D_coupling"].size == 3
    assert fields["spin.reference_velocity"].unit == "rad/s"
