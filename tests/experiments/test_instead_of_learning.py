from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tsd_casadi import Controller, Robot, Squat
from tsd_casadi.exceptions import InvalidValue
from tsd_clients import MujocoSimulator
from tsd_experiments.comparison import methods
from tsd_experiments.comparison.baselines.excitation import Excitation
from tsd_experiments.comparison.baselines.motion_recorder import MotionRecorder
from tsd_experiments.comparison.bench import Bench
from tsd_experiments.comparison.measure import measure
from tsd_experiments.comparison.prepare import prepare, prepare_generalized
from tsd_experiments.comparison.scenario import SCENARIOS, Scenario

QUICK = Scenario("quick", Squat(0.02, 1.0), other_frequency=0.9)


def rows_of(
    robot: Robot, controller: Controller, method: str, scenario: Scenario
) -> list[dict[str, Any]]:
    alternative, bench = prepare(robot, controller, method, scenario, iterations=1)
    squats = scenario.transfers.values()
    return [measure(alternative, bench, scenario, squat) for squat in squats]


def test_rows_are_plain_data(robot: Robot, controller: Controller) -> None:
    rows = rows_of(robot, controller, "task acceleration", QUICK)
    assert list(QUICK.transfers) == ["none", "amplitude", "frequency", "posture"]
    assert [row["amplitude"] for row in rows] == [0.02, 0.05, 0.02, 0.02]
    assert [row["frequency"] for row in rows] == [1.0, 1.0, 0.9, 1.0]
    assert [row["height"] for row in rows] == [0.0, 0.0, 0.0, 0.055]
    assert json.loads(json.dumps(rows)) == rows
    assert {row["numbers_learned"] for row in rows} == {25}
    (first, *_) = rows
    simulator = MujocoSimulator(robot, 0.1)
    without = simulator.run(controller, QUICK.squat, axes=("com.z",))
    assert first["rms_error_m"] < without.errors["com.z"].rms / 20


def test_the_constant_is_one_number(robot: Robot, controller: Controller) -> None:
    own = replace(QUICK, other_frequency=1.0)
    constant = rows_of(robot, controller, "constant", own)[0]
    assert constant["numbers_learned"] == 1
    assert constant["true_ac_rms_error_m"] > 0.5 * constant["true_rms_error_m"]


def test_generalised_lies_between_what_was_learned(robot: Robot, controller: Controller) -> None:
    alternative, bench = prepare_generalized(
        robot, controller, "task acceleration", QUICK, amplitudes=(0.04, 0.06), iterations=1
    )
    row = measure(alternative, bench, QUICK, QUICK.transfers["amplitude"])
    assert row["amplitude"] == 0.05
    assert row["numbers_learned"] == 50
    assert row["rms_error_m"] < 1e-3


def test_identified_controllers_know_the_true_weight(
    robot: Robot, controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled = []

    def keep(identified: Robot, on_compile: object) -> Controller:
        compiled.append(identified)
        return controller

    monkeypatch.setattr(methods, "compile_controller", keep)
    simulator = MujocoSimulator(robot, 0.1)
    bench = Bench(robot, controller, simulator, QUICK.squat, 1, QUICK.gains, QUICK.seed)
    alternative = methods.METHODS["identified, friction, excited"](bench)
    assert alternative.numbers_learned == 10 * (robot.n + 1) + 2 * robot.n
    (identified,) = compiled
    assert identified.weight == pytest.approx(robot.weight / 1.1, rel=0.02)


def test_excitation_turns_the_trunk_and_sways(robot: Robot, controller: Controller) -> None:
    recorder = MotionRecorder()
    run = MujocoSimulator(robot).run(
        controller, Squat(0.02, 0.25), compensators=[Excitation(), recorder], laps=2
    )
    assert run.steady
    assert not run.failures
    errors = run.log["all_errors"][run.log["measured"]]
    assert np.abs(errors).max() < 0.04  # followed, not only asked for
    q = np.array(recorder.q)[run.log["measured"]]
    assert np.ptp(2 * q[:, 3:6], axis=0).min() > 0.12
    com = np.array([robot.center_of_mass(each) for each in q[::20]])
    assert np.ptp(com[:, :2], axis=0).min() > 0.015


def test_refused(robot: Robot, controller: Controller) -> None:
    with pytest.raises(InvalidValue, match="task acceleration"):
        prepare(robot, controller, "magic", QUICK)
    with pytest.raises(InvalidValue, match="joint torque"):
        prepare_generalized(robot, controller, "integral", QUICK)


def test_scenarios_are_named_as_they_are_found() -> None:
    assert all(scenario.name == name for name, scenario in SCENARIOS.items())
