from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from tsd_casadi import Robot
from tsd_casadi.exceptions import ParityError
from tsd_clients.simulator.parity import TOLERANCE, check_parity, measure_parity, random_state


@pytest.fixture
def scene(robot: Robot) -> Any:
    """A fresh ``mujoco.MjModel`` to be spoilt."""
    return mujoco.MjModel.from_xml_path(str(robot.scene_path))


def test_urdf_and_scene_agree_at_100_random_states(any_robot: Robot) -> None:
    model = mujoco.MjModel.from_xml_path(str(any_robot.scene_path))
    parity = measure_parity(any_robot, model, states=100, seed=1)
    assert TOLERANCE == 1e-9
    for quantity, difference in vars(parity).items():
        assert 0 <= difference <= TOLERANCE, quantity
    check_parity(any_robot, model)


def test_the_measure_is_not_blind(robot: Robot, scene: Any) -> None:
    # numbers of some size are compared, so 1e-9 says something
    assert measure_parity(robot, scene).mass_matrix > 0
    scene.body("torso").mass[:] += 0.5
    parity = measure_parity(robot, scene)
    assert 0.4 < parity.mass_matrix < 5
    assert parity.bias_forces > 0.5 * 9
    assert parity.center_of_mass > 1e-4


def _mass(model: Any) -> None:
    model.body("L_shank").mass[:] += 1e-6


def _inertia(model: Any) -> None:
    model.body("L_shank").inertia[0] += 1e-6


def _center_of_mass(model: Any) -> None:
    model.body("L_shank").ipos[2] += 1e-6


def _placement(model: Any) -> None:
    model.body("L_shank").pos[2] += 1e-6


def _axis(model: Any) -> None:
    model.joint("L_KFE").axis[:] *= -1


def _armature(model: Any) -> None:
    model.dof_armature[8] = 1e-6


def _gravity(model: Any) -> None:
    model.opt.gravity[2] += 1e-6


PERTURBATIONS: dict[str, tuple[Callable[[Any], None], str]] = {
    "mass": (_mass, "mass matrix"),
    "inertia": (_inertia, "mass matrix"),
    "centre of mass": (_center_of_mass, "mass matrix"),
    "placement": (_placement, "mass matrix"),
    "axis": (_axis, "mass matrix"),
    "armature": (_armature, "mass matrix"),
    "gravity": (_gravity, "bias forces"),
}


@pytest.mark.parametrize("what", PERTURBATIONS)
def test_a_scene_that_is_off_by_a_millionth_is_refused_by_quantity(
    robot: Robot, scene: Any, what: str
) -> None:
    spoil, quantity = PERTURBATIONS[what]
    spoil(scene)
    with pytest.raises(ParityError, match=f"'hermes_lower': {quantity} from the URDF") as caught:
        check_parity(robot, scene)
    assert caught.value.quantity == quantity
    assert caught.value.difference > TOLERANCE


def test_the_reported_difference_is_that_of_the_worst_state(robot: Robot, scene: Any) -> None:
    _mass(scene)
    with pytest.raises(ParityError) as caught:
        check_parity(robot, scene)
    assert caught.value.difference == measure_parity(robot, scene).mass_matrix


def test_looks_are_no_part_of_parity(robot: Robot, scene: Any) -> None:
    scene.geom_size[:] *= 2
    scene.geom_rgba[:] = 0
    check_parity(robot, scene)


def test_more_states_never_look_better(robot: Robot, scene: Any) -> None:
    _mass(scene)
    few, many = (vars(measure_parity(robot, scene, states=n)) for n in (2, 20))
    assert all(many[name] >= few[name] for name in few)


def test_random_states_are_within_limits_and_nowhere_zero(robot: Robot) -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        state = random_state(robot, rng)
        assert np.linalg.norm(state.q[3:7]) == pytest.approx(1.0)
        assert np.all(state.q[7:] >= robot.model.lowerPositionLimit[7:])
        assert np.all(state.q[7:] <= robot.model.upperPositionLimit[7:])
        assert np.abs(state.q).min() > 0
        assert np.abs(state.v).min() > 0


def test_measuring_twice_gives_the_same(robot: Robot, scene: Any) -> None:
    assert measure_parity(robot, scene, seed=3) == measure_parity(robot, scene, seed=3)
