from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Robot, State
from tsd_casadi.exceptions import InvalidValue
from tsd_clients import MujocoSimulator
from tsd_clients.simulator.disturbances import Disturbance, Push, TorqueNoise
from tsd_clients.simulator.mujoco_plant import MujocoPlant

JOINTS = 17
TIMESTEP = 1e-3  # s


def nowhere() -> tuple[Any, Any]:
    """Arrays of a simulation without the simulation."""
    data = SimpleNamespace(xfrc_applied=np.zeros((20, 6)), qfrc_applied=np.zeros(6 + JOINTS))
    return data, SimpleNamespace(base_body=1, v_joints=np.arange(6, 6 + JOINTS))


def forces(disturbance: Disturbance, ticks: range) -> np.ndarray:
    """Force on the base, tick by tick, (ticks, 3) [N]."""
    found = []
    for tick in ticks:
        data, state_map = nowhere()
        disturbance.apply(data, state_map, TIMESTEP * tick)
        assert not np.delete(data.xfrc_applied, 1, axis=0).any()
        assert not data.xfrc_applied[:, 3:].any()
        found.append(data.xfrc_applied[1, :3])
    return np.array(found)


class Momentum:
    """Linear momentum of the flying robot before each step, from MuJoCo and Pinocchio."""

    def __init__(self, robot: Robot, disturbances: list[Disturbance], ticks: int) -> None:
        simulator = MujocoSimulator(robot)
        model = simulator.model
        model.opt.gravity[:] = 0.0
        q = robot.home.q.copy()
        q[2] += 1.0
        start = State(q, robot.home.v)
        self.mujoco, self.pinocchio, self.states = [], [], []
        watch = SimpleNamespace(reset=lambda: None, apply=self._watch)
        self._model, self._base = model, simulator.state_map.base_body
        plant = MujocoPlant(robot, model, start, start, (), [*disturbances, watch], 0)
        data = robot.model.createData()
        for tick in range(ticks):
            state, _ = plant.measure()
            pinocchio.computeCentroidalMomentum(robot.model, data, state.q, state.v)
            self.pinocchio.append(data.hg.linear.copy())
            self.states.append(state)
            plant.step(np.zeros(robot.n), tick * TIMESTEP)

    def _watch(self, data: Any, state_map: Any, time: float) -> None:
        mujoco.mj_subtreeVel(self._model, data)
        mass = self._model.body_subtreemass[self._base]
        self.mujoco.append(mass * data.subtree_linvel[self._base])
        assert data.ncon == 0


def test_a_push_gives_its_impulse_to_a_flying_robot(robot: Robot) -> None:
    push = Push(start=0.005, duration=0.02, impulse=(3.0, -2.0, 4.0))
    found = Momentum(robot, [push], 30)
    np.testing.assert_allclose(found.mujoco, found.pinocchio, atol=1e-9)
    gained = np.array(found.mujoco)
    np.testing.assert_allclose(gained[:6], 0, atol=1e-12)
    np.testing.assert_allclose(gained[-1], push.impulse, rtol=5e-3)
    # at a constant force: half of it after half of the time
    np.testing.assert_allclose(gained[15], np.divide(push.impulse, 2), rtol=5e-3)


def test_pushes_at_the_same_time_add_up(robot: Robot) -> None:
    pushes: list[Disturbance] = [
        Push(0.0, 0.01, (1.0, 0.0, 0.0)),
        Push(0.005, 0.01, (0.0, 2.0, 0.0)),
        Push(0.1, 0.01, (0.0, 0.0, 9.0)),
    ]
    found = Momentum(robot, pushes, 20)
    np.testing.assert_allclose(found.mujoco[-1], [1.0, 2.0, 0.0], atol=0.01)


@given(first=st.integers(0, 3000), count=st.integers(1, 100))
def test_a_push_lasts_as_many_steps_as_it_should(first: int, count: int) -> None:
    # written as people do: 0.7 and 0.1, of which no float is an exact multiple of 0.001
    start, duration = round(first * 1e-3, 3), round(count * 1e-3, 3)
    push = Push(start, duration, (6.0, 0.0, -3.0))
    found = forces(push, range(first - 2, first + count + 2))
    assert np.flatnonzero(found[:, 0]).tolist() == list(range(2, 2 + count))
    np.testing.assert_allclose(found.sum(axis=0) * TIMESTEP, push.impulse, rtol=1e-9)


@pytest.mark.parametrize("duration", [0.0, -0.1, math.nan])
def test_a_push_that_takes_no_time_is_refused(duration: float) -> None:
    with pytest.raises(InvalidValue, match="duration of a push"):
        Push(0.0, duration, (1.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("start", "impulse"), [(math.nan, (1.0, 0.0, 0.0)), (0.0, (0.0, math.inf, 0.0))]
)
def test_a_push_that_is_no_number_is_refused(
    start: float, impulse: tuple[float, float, float]
) -> None:
    with pytest.raises(InvalidValue, match="finite numbers"):
        Push(start, 0.1, impulse)


@pytest.mark.parametrize("standard_deviation", [-1.0, math.nan, math.inf])
def test_noise_that_cannot_be_is_refused(standard_deviation: float) -> None:
    with pytest.raises(InvalidValue, match="torque noise"):
        TorqueNoise(standard_deviation)


def noise_of(noise: TorqueNoise, ticks: int) -> np.ndarray:
    found = []
    for tick in range(ticks):
        data, state_map = nowhere()
        noise.apply(data, state_map, TIMESTEP * tick)
        assert not data.qfrc_applied[:6].any()
        found.append(data.qfrc_applied[6:])
    return np.array(found)


def test_torque_noise_is_white_and_of_the_given_standard_deviation() -> None:
    found = noise_of(TorqueNoise(1.5, seed=2), 5000) / 1.5
    bound = 5 / math.sqrt(found.size)
    assert abs(found.mean()) < bound
    assert abs((found**2).mean() - 1) < bound * math.sqrt(2)
    assert abs((found[1:] * found[:-1]).mean()) < bound
    assert abs((found[:, 0] * found[:, 1]).mean()) < 5 / math.sqrt(len(found))


def test_torque_noise_is_the_same_in_each_run_and_depends_on_the_seed() -> None:
    noise = TorqueNoise(1.0, seed=3)
    first = noise_of(noise, 10)
    assert (noise_of(noise, 10) != first).all()
    noise.reset()
    np.testing.assert_array_equal(noise_of(noise, 10), first)
    np.testing.assert_array_equal(noise_of(TorqueNoise(1.0, seed=3), 10), first)
    assert (noise_of(TorqueNoise(1.0, seed=4), 10) != first).all()
    assert TorqueNoise(1.0, seed=3) == noise


def test_a_plant_starts_its_noise_again(robot: Robot) -> None:
    noise = TorqueNoise(2.0, seed=1)
    one, again = (Momentum(robot, [noise], 10).states[-1].v for _ in range(2))
    np.testing.assert_array_equal(one, again)
    assert np.abs(one[6:]).max() > 1e-2


def test_torque_noise_is_internal_and_moves_no_momentum(robot: Robot) -> None:
    found = Momentum(robot, [TorqueNoise(2.0)], 10)
    assert np.abs(found.states[-1].v[6:]).max() > 1e-2
    np.testing.assert_allclose(found.mujoco, 0, atol=0.01)
