from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog, minimize

from tsd_casadi.explanation.least_distance import FARTHEST, find_nearest_point


def test_of_no_rows_the_origin_is_nearest() -> None:
    nearest = find_nearest_point(np.zeros((0, 3)), np.zeros(0))
    assert nearest.z is not None and not nearest.z.any()


def test_a_corner() -> None:
    nearest = find_nearest_point(-np.eye(2), np.array([-3.0, -4.0]))
    assert nearest.z == pytest.approx([3.0, 4.0])
    assert nearest.multipliers == pytest.approx([3.0, 4.0])


def test_two_walls_that_face_away_from_each_other() -> None:
    G, h = np.array([[1.0], [-1.0], [0.5]]), np.array([1.0, -3.0, 9.0])
    nearest = find_nearest_point(G, h)
    assert nearest.z is None
    assert nearest.multipliers == pytest.approx([0.5, 0.5, 0.0])


def test_a_row_without_coefficients_is_its_bound() -> None:
    G = np.array([[1.0, 0.0], [1e-12, 0.0]])
    assert find_nearest_point(G, np.array([1.0, 0.5])).z is not None
    assert find_nearest_point(G, np.array([1.0, -0.5])).z is None


@pytest.mark.parametrize(("share", "there"), [(0.9, True), (1.1, False)])
def test_how_far_a_point_may_be(share: float, there: bool) -> None:
    nearest = find_nearest_point(np.array([[-1.0]]), np.array([-share * FARTHEST]))
    assert (nearest.z is not None) is there


@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.integers(1, 20))
def test_it_agrees_with_a_linear_program(seed: int, nz: int, rows: int) -> None:
    rng = np.random.default_rng(seed)
    G, h = rng.normal(size=(rows, nz)), rng.normal(loc=0.3, size=rows)
    nearest = find_nearest_point(G, h)
    solved = linprog(np.zeros(nz), A_ub=G, b_ub=h, bounds=(None, None))
    assert (nearest.z is not None) == (solved.status == 0)
    u = nearest.multipliers
    assert (u >= 0).all()
    if nearest.z is None:
        assert G.T @ u == pytest.approx(0.0, abs=1e-8 * max(1.0, u.max()))
        assert h @ u == pytest.approx(-1.0, abs=1e-8)
    else:
        z = nearest.z
        assert (G @ z <= h + 1e-8 * (1 + np.linalg.norm(z))).all()
        assert z == pytest.approx(-G.T @ u, abs=1e-8 * (1 + np.linalg.norm(z)))
        assert u @ (G @ z - h) == pytest.approx(0.0, abs=1e-7 * (1 + z @ z))


def test_it_agrees_with_a_general_solver() -> None:
    rng = np.random.default_rng(1)
    G, h = rng.normal(size=(8, 3)), rng.normal(loc=-0.2, size=8)
    G[:, 0] = np.abs(G[:, 0])  # far to the left all hold
    nearest = find_nearest_point(G, h)
    assert nearest.z is not None
    solved = minimize(
        lambda z: z @ z,
        np.array([-10.0, 0.0, 0.0]),
        constraints={"type": "ineq", "fun": lambda z: h - G @ z},
        tol=1e-12,
    )
    assert nearest.z == pytest.approx(solved.x, abs=1e-5)
