from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tsd_casadi.constraints.center_of_pressure import center_of_pressure
from tsd_casadi.constraints.contact_acceleration import contact_acceleration
from tsd_casadi.constraints.friction import friction
from tsd_casadi.constraints.joint_acceleration import joint_acceleration
from tsd_casadi.constraints.joint_torque import joint_torque
from tsd_casadi.constraints.normal_torque import normal_torque
from tsd_casadi.constraints.rows import INFINITY, AccelerationBounds, Rows
from tsd_casadi.constraints.torque_speed import TorqueBounds
from tsd_casadi.constraints.unilateral_force import unilateral_force

NV = 8
# the second of two contacts, so that a wrong column shows
SELECTION = ca.SX(ca.DM(np.hstack((np.zeros((6, 6)), np.eye(6)))))
SOLE = (-0.05, 0.15, -0.04, 0.06)
MARGIN = 1e-9

forces = st.floats(-500, 500)
presses = st.floats(1, 1000)
moments = st.floats(-50, 50)
wrenches = st.tuples(forces, forces, presses, moments, moments, moments).map(np.array)


def numeric(rows: Rows) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    A, lower, upper = (
        np.array(ca.DM(ca.evalf(ca.densify(part)))) for part in (rows.A, rows.lower, rows.upper)
    )
    return A, lower[:, 0], upper[:, 0]


def slacks(rows: Rows, wrench: np.ndarray) -> dict[str, float]:
    A, lower, upper = numeric(rows)
    noise = np.random.default_rng(0).normal(size=NV + 6)
    values = A @ np.concatenate((noise, wrench))
    assert (upper == INFINITY).all()
    return dict(zip(rows.names, values - lower, strict=True))


def check_each(found: dict[str, float], meaning: dict[str, tuple[float, float]]) -> None:
    assert list(found) == list(meaning)
    for name, (small, large) in meaning.items():
        assume(abs(large - small) > MARGIN)
        assert (found[name] >= 0) == (small <= large), name


@given(wrench=wrenches)
def test_center_of_pressure_is_inside_the_sole(wrench: np.ndarray) -> None:
    rows = center_of_pressure("foot", ca.SX(ca.DM(SOLE)), NV, SELECTION)
    x, y = -wrench[4] / wrench[2], wrench[3] / wrench[2]
    check_each(
        slacks(rows, wrench),
        {
            "foot.center_of_pressure.-x": (SOLE[0], x),
            "foot.center_of_pressure.+x": (x, SOLE[1]),
            "foot.center_of_pressure.-y": (SOLE[2], y),
            "foot.center_of_pressure.+y": (y, SOLE[3]),
        },
    )


@given(x=st.floats(-0.3, 0.3), y=st.floats(-0.3, 0.3), press=presses)
def test_a_pure_push_at_a_point_is_allowed_iff_the_point_is_on_the_sole(
    x: float, y: float, press: float
) -> None:
    rows = center_of_pressure("foot", ca.SX(ca.DM(SOLE)), NV, SELECTION)
    force = np.array([0.0, 0.0, press])
    wrench = np.concatenate((force, np.cross([x, y, 0.0], force)))
    edges = np.array([x - SOLE[0], SOLE[1] - x, y - SOLE[2], SOLE[3] - y])
    assume(np.abs(edges).min() > MARGIN)
    allowed = min(slacks(rows, wrench).values()) >= 0
    assert allowed == (edges.min() > 0)


@given(wrench=wrenches, mu=st.floats(0.05, 2.0))
def test_friction_rows_are_the_inscribed_pyramid(wrench: np.ndarray, mu: float) -> None:
    side = mu / np.sqrt(2) * wrench[2]
    check_each(
        slacks(friction("foot", ca.SX(mu), NV, SELECTION), wrench),
        {
            "foot.friction.-x": (-side, wrench[0]),
            "foot.friction.+x": (wrench[0], side),
            "foot.friction.-y": (-side, wrench[1]),
            "foot.friction.+y": (wrench[1], side),
        },
    )


@given(wrench=wrenches, mu=st.floats(0.05, 2.0))
def test_friction_pyramid_lies_between_two_cones(wrench: np.ndarray, mu: float) -> None:
    allowed = min(slacks(friction("foot", ca.SX(mu), NV, SELECTION), wrench).values())
    tangential = np.hypot(wrench[0], wrench[1])
    if allowed >= 0:
        assert tangential <= mu * wrench[2] * (1 + 1e-12)
    if tangential < mu / np.sqrt(2) * wrench[2]:
        assert allowed >= 0


def test_friction_pyramid_touches_the_cone() -> None:
    mu = 0.5
    rows = friction("foot", ca.SX(mu), NV, SELECTION)
    corner = mu / np.sqrt(2) * 100
    at_corner = slacks(rows, np.array([corner, -corner, 100.0, 0, 0, 0]))
    assert at_corner["foot.friction.+x"] == pytest.approx(0, abs=1e-12)
    assert at_corner["foot.friction.-y"] == pytest.approx(0, abs=1e-12)


@given(wrench=wrenches, gamma=st.floats(0.001, 0.5))
def test_normal_torque_is_bounded_by_the_press(wrench: np.ndarray, gamma: float) -> None:
    check_each(
        slacks(normal_torque("foot", ca.SX(gamma), NV, SELECTION), wrench),
        {
            "foot.normal_torque.-z": (-gamma * wrench[2], wrench[5]),
            "foot.normal_torque.+z": (wrench[5], gamma * wrench[2]),
        },
    )


@given(press=forces, least=st.floats(0, 50), active=st.floats(0, 1))
def test_the_normal_force_stays_between_what_the_contact_may_carry(
    press: float, least: float, active: float
) -> None:
    rows = unilateral_force("foot", ca.SX(least), ca.SX(100.0), ca.SX(active), NV, SELECTION)
    A, lower, upper = numeric(rows)
    value = A @ np.concatenate((np.ones(NV + 6), [1.0, 2.0, press, 3.0, 4.0, 5.0]))
    assert value == press
    assert lower == active * least
    # where it is 0 other rows hold the force at zero
    assert upper == (active * 100.0 if active > 0 else INFINITY)


# a point: the last three of two soles and a point's forces
POINT = ca.SX(ca.DM(np.hstack((np.zeros((3, 12)), np.eye(3)))))


@given(force=st.tuples(forces, forces, presses).map(np.array), mu=st.floats(0.05, 2.0))
def test_a_points_rows_are_those_of_a_soles_force(force: np.ndarray, mu: float) -> None:
    wrench = np.concatenate((force, [7.0, -8.0, 9.0]))
    x = np.concatenate((np.full(NV + 12, 3.0), force))
    for at_point, at_sole in (
        (friction("foot", ca.SX(mu), NV, POINT), friction("foot", ca.SX(mu), NV, SELECTION)),
        (
            unilateral_force("foot", ca.SX(4.0), ca.SX(9.0), ca.SX(0.5), NV, POINT),
            unilateral_force("foot", ca.SX(4.0), ca.SX(9.0), ca.SX(0.5), NV, SELECTION),
        ),
    ):
        A, lower, _ = numeric(at_point)
        assert not A[:, : NV + 12].any()
        A_sole, lower_sole, _ = numeric(at_sole)
        x_sole = np.concatenate((np.full(NV + 6, 3.0), wrench))
        np.testing.assert_allclose(A @ x - lower, A_sole @ x_sole - lower_sole, rtol=1e-12)


@pytest.mark.parametrize("size", [3, 6])
@pytest.mark.parametrize("active", [0.0, 1.0])
def test_a_contact_holds_its_acceleration_or_its_forces(size: int, active: float) -> None:
    rng = np.random.default_rng(0)
    J, drift = rng.normal(size=(size, NV)), rng.normal(size=size)
    selection = np.hstack((np.zeros((size, 6)), np.eye(size)))
    rows = contact_acceleration(
        "foot", ca.SX(ca.DM(J)), ca.SX(ca.DM(drift)), ca.SX(active), ca.SX(ca.DM(selection))
    )
    A, lower, upper = numeric(rows)
    assert rows.names == tuple(
        f"foot.acceleration.{a}" for a in ("x", "y", "z", "rx", "ry", "rz")[:size]
    )
    assert rows.equality
    np.testing.assert_array_equal(lower, upper)
    qdd, forces = rng.normal(size=NV), rng.normal(size=6 + size)
    expected = J @ qdd + drift if active else forces[6:]
    np.testing.assert_allclose(A @ np.concatenate((qdd, forces)) - lower, expected, atol=1e-12)


CONES: dict[str, Callable[[], Rows]] = {
    "centre of pressure": lambda: center_of_pressure("foot", ca.SX(ca.DM(SOLE)), NV, SELECTION),
    "friction": lambda: friction("foot", ca.SX(0.5), NV, SELECTION),
    "normal torque": lambda: normal_torque("foot", ca.SX(0.1), NV, SELECTION),
}


@pytest.mark.parametrize("cone", CONES)
def test_cones_hold_at_zero_and_scale(cone: str) -> None:
    rows = CONES[cone]()
    assert not any(slacks(rows, np.zeros(6)).values())
    wrench = np.array([10.0, -20.0, 300.0, 4.0, -5.0, 6.0])
    once, twice = slacks(rows, wrench), slacks(rows, 2 * wrench)
    assert all(twice[name] == pytest.approx(2 * once[name]) for name in once)


@pytest.mark.parametrize("cone", CONES)
def test_cones_refuse_to_be_pulled(cone: str) -> None:
    assert min(slacks(CONES[cone](), np.array([0.0, 0.0, -10.0, 0, 0, 0])).values()) < 0


@pytest.mark.parametrize("cone", CONES)
def test_cones_do_not_touch_accelerations_or_other_contacts(cone: str) -> None:
    A, lower, _ = numeric(CONES[cone]())
    assert not A[:, : NV + 6].any()
    assert not lower.any()


def test_joint_acceleration_bounds_the_joints_and_not_the_base() -> None:
    rows = joint_acceleration(["hip", "knee"], ca.SX(ca.DM([3.0, 4.0])), [], NV + 12)
    A, lower, upper = numeric(rows)
    np.testing.assert_array_equal(A, np.eye(NV, NV + 12))
    np.testing.assert_array_equal(upper, [INFINITY] * 6 + [3.0, 4.0])
    np.testing.assert_array_equal(lower, -upper)
    assert rows.names[6:] == ("joint_acceleration.hip", "joint_acceleration.knee")
    assert all(".base." in name for name in rows.names[:6])


@given(
    bounds=st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), max_size=3),
)
def test_bounds_of_an_acceleration_never_contradict_each_other(
    bounds: list[tuple[float, float]],
) -> None:
    narrower = [AccelerationBounds(ca.SX(low), ca.SX(high)) for low, high in bounds]
    _, lower, upper = numeric(joint_acceleration(["hip"], ca.SX(4.0), narrower, NV + 12))
    assert -4 <= lower[-1] <= upper[-1] <= 4
    inside = max([-4.0, *(low for low, _ in bounds)]), min([4.0, *(high for _, high in bounds)])
    if inside[0] <= inside[1]:
        assert (lower[-1], upper[-1]) == inside


@given(
    x=st.lists(st.floats(-10, 10), min_size=NV + 6, max_size=NV + 6).map(np.array),
    limits=st.tuples(st.floats(1, 100), st.floats(1, 100)),
)
def test_joint_torque_rows_bound_the_affine_torque(
    x: np.ndarray, limits: tuple[float, float]
) -> None:
    A_tau = np.random.default_rng(0).normal(size=(2, NV + 6))
    h_a = np.array([5.0, -7.0])
    rows = joint_torque(
        ["hip", "knee"],
        ca.SX(ca.DM(A_tau)),
        ca.SX(ca.DM(h_a)),
        TorqueBounds(ca.SX(-ca.DM(limits)), ca.SX(ca.DM(limits))),
    )
    A, lower, upper = numeric(rows)
    tau = A_tau @ x + h_a
    assume((np.abs(np.abs(tau) - limits) > MARGIN).all())
    inside = (lower <= A @ x) & (A @ x <= upper)
    np.testing.assert_array_equal(inside, np.abs(tau) <= limits)
    assert rows.names == ("joint_torque.hip", "joint_torque.knee")
