from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest

from tsd_casadi import Controller, Robot, State
from tsd_casadi.state import Vector
from tsd_clients import MujocoSimulator
from tsd_clients.simulator.disturbances import Disturbance
from tsd_clients.simulator.effects import EFFECTS, SENSOR_EFFECTS
from tsd_clients.simulator.mujoco_plant import MujocoPlant
from tsd_clients.simulator.state_map import StateMap

TIMESTEP = 1e-3  # s


class Watch(Disturbance):
    """Disturbs nothing and remembers what the motors were told."""

    def __init__(self) -> None:
        self.controls: list[Vector] = []
        self.resets = 0

    def reset(self) -> None:
        self.resets += 1

    def apply(self, data: Any, state_map: StateMap, time: float) -> None:
        self.controls.append(data.ctrl[state_map.actuators].copy())


def plant_of(
    robot: Robot,
    effects: Sequence[str] = (),
    disturbances: Sequence[Disturbance] = (),
    seed: int = 0,
    start: State | None = None,
) -> MujocoPlant:
    simulator = MujocoSimulator(robot, hardware=effects)
    start = start or simulator.near(robot.home, 3)
    return MujocoPlant(
        robot, simulator.model, start, robot.home, simulator.hardware, disturbances, seed
    )


@pytest.fixture(scope="module")
def torque(robot: Robot, controller: Controller) -> Vector:
    """What holds the robot at home."""
    return controller.tick(robot.home, controller.command()).tau


def measured_over(plant: MujocoPlant, torque: Vector, ticks: int) -> list[tuple[State, State]]:
    states = []
    for tick in range(ticks):
        states.append(plant.measure())
        plant.step(torque, tick * TIMESTEP)
    return states


def test_starts_where_it_was_put(robot: Robot) -> None:
    start = MujocoSimulator(robot).near(robot.home, 3)
    true, measured = plant_of(robot).measure()
    assert measured is true
    np.testing.assert_allclose(true.q, start.q, atol=1e-15)
    np.testing.assert_allclose(true.v, 0, atol=1e-15)


def test_a_step_is_one_of_mujocos(robot: Robot, torque: Vector) -> None:
    # measuring and applying in two halves is the same as MuJoCo's own step
    simulator = MujocoSimulator(robot)
    data = mujoco.MjData(simulator.model)
    simulator.state_map.write(data, simulator.near(robot.home, 3))
    data.ctrl[simulator.state_map.actuators] = torque
    for true, _ in measured_over(plant_of(robot), torque, 200):
        expected = simulator.state_map.read(data)
        np.testing.assert_array_equal(true.q, expected.q)
        np.testing.assert_array_equal(true.v, expected.v)
        mujoco.mj_step(simulator.model, data)
    assert np.abs(true.v).max() > 1e-3


def test_centre_of_mass_is_that_of_the_state_just_measured(robot: Robot, torque: Vector) -> None:
    plant, data = plant_of(robot), robot.model.createData()
    for tick in range(100):
        true, _ = plant.measure()
        com = pinocchio.centerOfMass(robot.model, data, true.q)
        np.testing.assert_allclose(plant.com, com, atol=1e-9)
        plant.step(torque, tick * TIMESTEP)
        np.testing.assert_allclose(plant.com, com, atol=1e-9)


def test_earlier_measurements_are_not_overwritten(robot: Robot, torque: Vector) -> None:
    plant = plant_of(robot, ["all"])
    first = plant.measure()
    kept = [x.copy() for state in first for x in (state.q, state.v)]
    plant.step(torque, 0.0)
    measured_over(plant, torque, 20)
    for before, after in zip(kept, (x for s in first for x in (s.q, s.v)), strict=True):
        np.testing.assert_array_equal(before, after)


def test_torque_is_applied_as_commanded_without_hardware(robot: Robot, torque: Vector) -> None:
    watch = Watch()
    measured_over(plant_of(robot, disturbances=[watch]), torque, 3)
    np.testing.assert_array_equal(watch.controls, [torque] * 3)
    assert watch.resets == 1


def test_torque_comes_late_with_a_delay(robot: Robot, torque: Vector) -> None:
    hardware = robot.description.hardware
    assert hardware is not None
    late = round(hardware.torque_delay / TIMESTEP)
    assert late >= 1
    watch = Watch()
    plant = plant_of(robot, ["delay"], [watch])
    for tick in range(10):
        plant.measure()
        plant.step(torque + tick, tick * TIMESTEP)
    found = [float(control[0] - torque[0]) for control in watch.controls]
    assert found == pytest.approx([max(tick - late, 0) for tick in range(10)])


@pytest.mark.parametrize("effect", SENSOR_EFFECTS)
def test_each_sensor_effect_changes_what_it_should(
    robot: Robot, torque: Vector, effect: str
) -> None:
    truths = measured_over(plant_of(robot, start=robot.home), torque, 20)
    states = measured_over(plant_of(robot, [effect], start=robot.home), torque, 20)
    changed = {"angles": 0.0, "velocities": 0.0, "base": 0.0}
    for (true, measured), (expected, _) in zip(states, truths, strict=True):
        # the robot itself does not know what its sensors say
        np.testing.assert_array_equal(true.q, expected.q)
        off_q, off_v = np.abs(measured.q - true.q), np.abs(measured.v - true.v)
        changed["angles"] = max(changed["angles"], off_q[7:].max())
        changed["velocities"] = max(changed["velocities"], off_v[6:].max())
        changed["base"] = max(changed["base"], off_q[:7].max(), off_v[:6].max())
    part = {"differencing": "velocities", "flat_feet": "base"}.get(effect, "angles")
    assert {name for name, off in changed.items() if off > 0} == {part}
    assert changed[part] < 0.05


def test_all_effects_together_measure_a_standing_robot_well(robot: Robot, torque: Vector) -> None:
    for true, measured in measured_over(plant_of(robot, EFFECTS), torque, 30):
        assert np.abs(measured.q - true.q).max() < 5e-3
        assert np.abs(measured.v - true.v).max() < 0.3
        assert np.linalg.norm(measured.q[3:7]) == pytest.approx(1, abs=1e-12)


def test_sensor_noise_depends_on_the_seed_only(robot: Robot) -> None:
    one, again, other = (plant_of(robot, ["noise"], seed=seed).measure() for seed in (1, 1, 2))
    np.testing.assert_array_equal(one[1].q, again[1].q)
    assert (one[1].q[7:] != other[1].q[7:]).all()
    np.testing.assert_array_equal(one[0].q, other[0].q)
