from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lsim, lti

from tsd_casadi import Controller, Robot, Squat, Status
from tsd_casadi.exceptions import InvalidValue
from tsd_clients import MujocoSimulator
from tsd_experiments.comparison.baselines.disturbance_observer import (
    DisturbanceObserver,
    usual_bandwidth,
)

AXES = ("com.z",)
P, D, DT = 50.0, 2 * np.sqrt(50.0), 1e-4


def setting(robot: Robot | None = None, dt: float = DT) -> Any:
    return SimpleNamespace(
        robot=robot,
        axes=("com.z",),
        learned=1,
        index=np.array([1]),
        period=dt,
        controller=SimpleNamespace(format=SimpleNamespace(component_index=lambda *_: 1)),
    )


def fields(xd: float, xdd: float, feedforward: float, damping: float = D) -> dict[str, np.ndarray]:
    values = {
        "P": P,
        "D": damping,
        "reference_velocity": xd,
        "reference_acceleration": xdd,
        "feedforward": feedforward,
    }
    return {f"com.{name}": np.array([7.0, value]) for name, value in values.items()}


def simulate(bandwidth: float, disturbance: Any, seconds: float) -> tuple[np.ndarray, ...]:
    """Time, errors and estimates of a double integrator that follows a sine."""
    observer = DisturbanceObserver(bandwidth)
    observer.start(setting())
    x = v = 0.0
    times = DT * np.arange(round(seconds / DT))
    errors, estimates = [], []
    for t in times:
        xr, xdr, xddr = 0.03 * np.sin(t), 0.03 * np.cos(t), -0.03 * np.sin(t)
        moment: Any = SimpleNamespace(feedforward=np.zeros(1))
        observer.before(moment)
        feedback = P * (xr - x) + D * (xdr - v)
        moment.command = fields(xdr, xddr, moment.feedforward[0])
        moment.tick = SimpleNamespace(
            status=Status.OK, error=np.array([5.0, xr - x]), feedback=np.array([5.0, feedback])
        )
        observer.after(moment)
        errors.append(xr - x)
        estimates.append(observer.disturbance[0])
        # what is missing is subtracted by the world
        v += DT * (xddr + moment.feedforward[0] + feedback - disturbance(t))
        x += DT * v
    return times, np.array(errors), np.array(estimates)


def test_it_converges_to_a_constant_disturbance() -> None:
    _, errors, estimates = simulate(20.0, lambda t: 0.7, 4.0)
    assert estimates[-1] == pytest.approx(0.7, rel=1e-3)
    assert abs(errors[-1]) < 1e-5
    assert np.abs(errors).max() > 1e-3


def test_the_estimate_is_the_disturbance_behind_a_low_pass() -> None:
    def disturbance(t: float) -> float:
        return 0.5 * np.sin(9 * t)

    g = 20.0
    times, _, estimates = simulate(g, disturbance, 3.0)
    _, filtered, _ = lsim(lti([g], [1.0, g]), [disturbance(t) for t in times], times)
    np.testing.assert_allclose(estimates, filtered, atol=2e-3)


def test_it_is_a_pid_controller_on_a_double_integrator() -> None:
    g = 12.0
    times, errors, _ = simulate(g, lambda t: 0.3, 2.0)
    pid = lti([1.0, 0.0], [1.0, D + g, P + g * D, g * P])
    # the reference starts with a velocity that the robot has not
    start = lti([1.0, g], pid.den)
    _, to_disturbance, _ = lsim(pid, np.full(len(times), 0.3), times)
    _, to_velocity = start.impulse(T=times)
    np.testing.assert_allclose(errors, to_disturbance + 0.03 * to_velocity, atol=1e-4)


def test_no_damping_hides_the_velocity() -> None:
    observer = DisturbanceObserver(10.0)
    observer.start(setting())
    tick = SimpleNamespace(status=Status.OK, error=np.zeros(2), feedback=np.zeros(2))
    moment: Any = SimpleNamespace(tick=tick, command=fields(0, 0, 0, damping=0.0))
    with pytest.raises(InvalidValue, match=r"D of com\.z"):
        observer.after(moment)


@pytest.mark.parametrize(
    "arguments", [{"bandwidth": 0.0}, {"bandwidth": np.nan}, {"limit": -1.0}, {"limit": np.inf}]
)
def test_refused(arguments: dict[str, float]) -> None:
    with pytest.raises(InvalidValue):
        DisturbanceObserver(**arguments)


@pytest.mark.parametrize(("crossover", "phase", "gain"), [(0.5, 45, 5), (1.0, 30, 2.5)])
def test_usual_bandwidth_leaves_margins(
    robot: Robot, crossover: float, phase: float, gain: float
) -> None:
    hardware = robot.description.hardware
    assert hardware is not None
    g = usual_bandwidth(robot, D, crossover)
    w = np.geomspace(20, 300, 20000)
    s = 1j * w
    loop = ((D + g) * s**2 + (P + g * D) * s + g * P) / s**3
    loop *= np.exp(-s * hardware.torque_delay) / (s * hardware.torque_lag + 1)
    loop /= s * hardware.velocity_filter + 1
    crossing = np.flatnonzero(np.abs(loop) > 1)[-1]
    assert w[crossing] == pytest.approx(D + g, rel=0.2)
    assert phase < 180 + np.degrees(np.angle(loop[crossing])) < phase + 5
    turned = np.flatnonzero(loop.imag > 0)[0]
    assert gain < 1 / abs(loop[turned]) < gain + 1


def test_lags_that_leave_no_room_are_told(robot: Robot) -> None:
    with pytest.raises(InvalidValue, match="lags"):
        usual_bandwidth(robot, 1e3)


@pytest.mark.parametrize("crossover", [0.5, 1.0])
def test_it_is_stable_on_a_robot_with_lags(
    robot: Robot, controller: Controller, crossover: float
) -> None:
    simulator = MujocoSimulator(robot, 0.1, ["all"])
    observer = DisturbanceObserver(usual_bandwidth(robot, D, crossover))
    run = simulator.run(controller, Squat(0.02, 1.0), axes=AXES, compensators=[observer])
    without = simulator.run(controller, Squat(0.02, 1.0), axes=AXES)
    assert run.steady
    assert not run.failures
    with_it, without_it = (each.errors["com.z"].ac_rms for each in (run, without))
    assert with_it is not None and without_it is not None
    assert with_it < without_it / 4
