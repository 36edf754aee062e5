from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Robot
from tsd_casadi.exceptions import InvalidValue
from tsd_clients import ModelError, MujocoSimulator


def mass(model: mujoco.MjModel) -> float:
    return float(model.body_mass.sum())


def center_of_mass(simulator: MujocoSimulator) -> np.ndarray:
    data = mujoco.MjData(simulator.model)
    simulator.state_map.write(data, simulator.robot.home)
    mujoco.mj_forward(simulator.model, data)
    return np.array(data.subtree_com[simulator.state_map.base_body])


@given(uniform=st.floats(-0.9, 9.0), links=st.integers(1, 40))
def test_a_uniform_error_is_one_plus_e_on_every_link(uniform: float, links: int) -> None:
    np.testing.assert_array_equal(ModelError(uniform).factors(links), np.full(links, 1 + uniform))


@given(uniform=st.floats(-0.3, 1.0), per_link=st.floats(-0.5, 0.5), seed=st.integers(0, 2**32 - 1))
def test_each_link_is_off_by_plus_or_minus_the_same(
    uniform: float, per_link: float, seed: int
) -> None:
    factors = ModelError(uniform, per_link, seed).factors(18)
    np.testing.assert_allclose(np.abs(factors - 1 - uniform), abs(per_link), atol=1e-15)
    np.testing.assert_array_equal(factors, ModelError(uniform, per_link, seed).factors(18))


def test_signs_depend_on_the_seed_and_are_fair() -> None:
    signs = np.array([np.sign(ModelError(0, 0.1, seed).factors(18) - 1) for seed in range(200)])
    assert len({tuple(row) for row in signs}) > 190
    # 3600 fair coins: the mean is within five standard deviations of zero
    assert abs(signs.mean()) < 5 / math.sqrt(signs.size)


def test_the_total_mass_is_that_of_the_links(robot: Robot) -> None:
    exact = MujocoSimulator(robot).model
    assert mass(exact) * 9.81 == pytest.approx(robot.weight, rel=1e-12)
    assert mass(MujocoSimulator(robot, 0.25).model) == pytest.approx(mass(exact) / 1.25, rel=1e-12)
    error = ModelError(0.1, 0.2, seed=4)
    wrong = MujocoSimulator(robot, error).model
    factors = error.factors(wrong.nbody - 1)
    assert set(np.round(factors, 12)) == {0.9, 1.3}
    np.testing.assert_allclose(wrong.body_mass[1:] * factors, exact.body_mass[1:], rtol=1e-14)
    np.testing.assert_allclose(
        wrong.body_inertia[1:] * factors[:, None], exact.body_inertia[1:], rtol=1e-14
    )
    assert mass(wrong) == pytest.approx(np.sum(exact.body_mass[1:] / factors), rel=1e-14)


def test_only_errors_that_differ_move_the_centre_of_mass(robot: Robot) -> None:
    uniform = center_of_mass(MujocoSimulator(robot, 0.3))
    np.testing.assert_allclose(uniform, robot.home_com, atol=1e-9)
    off = center_of_mass(MujocoSimulator(robot, ModelError(0.0, 0.1, seed=1))) - robot.home_com
    assert 1e-4 < np.linalg.norm(off) < 0.1


def test_a_number_is_a_uniform_error(robot: Robot) -> None:
    assert MujocoSimulator(robot, 0.1).model_error == ModelError(0.1)


@pytest.mark.parametrize(
    ("uniform", "per_link"),
    [
        (-0.91, 0.0),
        (9.1, 0.0),
        (-0.5, 0.41),
        (-0.5, -0.41),
        (0.0, 1.0),
        (8.9, 0.2),
        (math.nan, 0.0),
        (0.0, math.nan),
        (math.inf, 0.0),
        (0.0, math.inf),
    ],
)
def test_links_without_mass_are_refused(uniform: float, per_link: float) -> None:
    with pytest.raises(InvalidValue, match=r"model error is .*0\.1 is 10 %"):
        ModelError(uniform, per_link)


def test_records_say_what_counts() -> None:
    assert ModelError(0.1).settings() == {"model_error": 0.1}
    assert ModelError(0.1, 0.05, 7).settings() == {
        "model_error": 0.1,
        "link_error": 0.05,
        "link_error_seed": 7,
    }
