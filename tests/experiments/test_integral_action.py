from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lti, step

from tsd_casadi import Controller, Robot, Squat, Status
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.compensator import Compensator
from tsd_clients import MujocoSimulator
from tsd_experiments.comparison.baselines.integral_action import ROUTH_SHARE, IntegralAction

P, D, DT = 50.0, 2 * np.sqrt(50.0), 1e-3
GAINS = {"com.P": np.array([0.0, P]), "com.D": np.array([0.0, D])}
SETTING: Any = SimpleNamespace(
    learned=1,
    index=np.array([1]),
    period=DT,
    gain=lambda command, name: command[f"com.{name}"][1:],
)


def simulate(correction: Compensator, disturbance: float, seconds: float) -> np.ndarray:
    """Error of a double integrator with a constant disturbance, tick by tick."""
    correction.start(SETTING)
    x = v = 0.0
    errors = []
    for _ in range(round(seconds / DT)):
        moment: Any = SimpleNamespace(feedforward=np.zeros(2), command=GAINS)
        correction.before(moment)
        moment.tick = SimpleNamespace(status=Status.OK, error=np.array([9.0, -x]))
        correction.after(moment)
        v += DT * (moment.feedforward[0] - P * x - D * v + disturbance)
        x += DT * v
        errors.append(-x)
        assert moment.feedforward[1] == 0.0  # an axis that only moves
    return np.array(errors)


@pytest.mark.parametrize("Ki", [None, 200.0])
def test_the_error_follows_its_transfer_function(Ki: float | None) -> None:
    errors = simulate(IntegralAction(Ki), disturbance=0.7, seconds=4.0)
    gain = ROUTH_SHARE * P * D if Ki is None else Ki
    time = DT * np.arange(1, len(errors) + 1)
    _, closed_form = step(lti([-0.7, 0.0], [1.0, D, P, gain]), T=np.concatenate(([0.0], time)))
    np.testing.assert_allclose(errors, closed_form[1:], atol=2e-4)
    assert np.abs(errors).max() > 5e-3


@pytest.mark.parametrize(("share", "stable"), [(0.9, True), (1.1, False)])
def test_the_routh_limit(share: float, stable: bool) -> None:
    errors = np.abs(simulate(IntegralAction(share * P * D, limit=1e3), 0.1, seconds=30.0))
    assert (errors[-5000:].max() < 0.5 * errors[5000:10000].max()) == stable


def test_the_integral_stops_at_its_limit_and_comes_back() -> None:
    action = IntegralAction(200.0, limit=0.5)
    errors = simulate(action, disturbance=2.0, seconds=10.0)
    assert action.integral == pytest.approx([-0.5])
    assert errors[-1] == pytest.approx(-(2.0 - 0.5) / P, rel=1e-3)
    simulate(action, disturbance=0.0, seconds=0.01)
    assert abs(action.integral) < 0.5


def test_a_failed_tick_is_not_summed_up() -> None:
    action = IntegralAction(200.0)
    action.start(SETTING)
    moment: Any = SimpleNamespace(feedforward=np.zeros(2), command=GAINS)
    moment.tick = SimpleNamespace(status=Status.SINGULAR, error=np.ones(2))
    action.after(moment)
    assert action.integral == 0.0


@pytest.mark.parametrize(
    "arguments", [{"Ki": 0.0}, {"Ki": -1.0}, {"Ki": np.nan}, {"limit": 0.0}, {"limit": np.inf}]
)
def test_refused(arguments: dict[str, float]) -> None:
    with pytest.raises(InvalidValue):
        IntegralAction(**arguments)


def test_it_removes_the_mean_of_every_axis_on_a_robot_with_lags(
    robot: Robot, controller: Controller
) -> None:
    simulator = MujocoSimulator(robot, 0.1, ["lag", "delay", "differencing"])
    action = IntegralAction()
    for _ in range(2):  # the second run starts afresh
        run = simulator.run(controller, Squat(0.01, 1.0), compensators=[action])
        assert run.steady
        assert len(run.learned) == 3
        errors = run.measured("error")
        assert np.abs(errors.mean(axis=0)).max() < 2e-4
        assert run.log["error"][0] == pytest.approx(run.log["error"][1], abs=1e-4)
        assert not run.log["feedforward"][0].any()
