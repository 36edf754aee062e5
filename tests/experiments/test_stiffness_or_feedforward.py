from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib import pyplot as plt
from scipy.integrate import solve_ivp

from tsd_casadi import Controller, Robot, Squat
from tsd_clients import MujocoSimulator
from tsd_clients.simulator.disturbances import Push
from tsd_clients.simulator.mujoco_plant import MujocoPlant
from tsd_experiments.beyond.stiffness_or_feedforward.disturb import PUSH_DURATION
from tsd_experiments.beyond.stiffness_or_feedforward.experiment import StiffnessOrFeedforward
from tsd_experiments.beyond.stiffness_or_feedforward.run_at import Stiffness
from tsd_experiments.beyond.stiffness_or_feedforward.sweep_results import (
    end_of,
    highest_stable,
    stiffness_for,
)
from tsd_experiments.beyond.stiffness_or_feedforward.tables import IMPULSE
from tsd_experiments.beyond.stiffness_or_feedforward.witness import Witness
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.experiment import Experiment
from tsd_experiments.harness.job import Result


def row(factor: float, error: float | None, stable: bool = True) -> dict[str, Any]:
    return {"factor": factor, "rms_error_m": error, "stable": stable}


@given(st.floats(1e-4, 1.0), st.floats(0.5, 2.0), st.floats(1e-7, 1e-2))
def test_a_power_law_is_found_inside_and_outside(C: float, power: float, error: float) -> None:
    rows = [row(factor, C * factor**-power) for factor in (0.2, 1, 5, 30)]
    rows.append(row(100.0, None, False))
    assert stiffness_for(rows, error) == pytest.approx((C / error) ** (1 / power), rel=1e-6)
    assert highest_stable(rows) == 30


def test_what_ends_a_sweep_is_the_least_stiff_failure() -> None:
    rows = [
        {**row(1.0, 1e-3), "fell": False, "failures": {}},
        {**row(8.0, None, False), "fell": True, "failures": {}},
        {**row(4.0, None, False), "fell": False, "failures": {"infeasible": 2}},
    ]
    assert end_of(rows) == "2 ticks infeasible"
    assert end_of(rows[:2]) == "a fall"
    assert end_of(rows[:1]) == "nothing in the sweep"


def test_witness_sees_the_ground_force_of_the_step_before(
    robot: Robot, controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    witness, forces = Witness(), []
    step = MujocoPlant.step

    def weigh(self: MujocoPlant, tau: Any, time: float) -> None:
        step(self, tau, time)
        forces.append(np.linalg.norm(self.ground_force()[0]))

    monkeypatch.setattr(MujocoPlant, "step", weigh)
    push = Push(1.5, 0.1, (0.0, 5.0, -5.0))
    run = MujocoSimulator(robot, 0.1, ["friction"]).run(
        controller, Squat(0.03, 1.0), laps=2, disturbances=[push, witness]
    )
    assert witness.force[1:] == pytest.approx(np.array(forces[:-1]), abs=1e-9)
    assert witness.com[:, 2] == pytest.approx(
        robot.home_com[2] + run.along("reference", "com.z") - run.along("true_error", "com.z")
    )


def test_stiffness_is_that_of_the_case(robot: Robot, controller: Controller) -> None:
    case = Case(frequency=1.0, laps=2).at_stiffness(4.0)
    simulator = case.simulator(robot)
    usual = simulator.run(controller, case.motion, laps=2, gains=case.gains)
    run = simulator.run(controller, case.motion, laps=2, compensators=[Stiffness(4.0)])
    assert run.gains == usual.gains
    assert run.log["tau"] == pytest.approx(usual.log["tau"], abs=1e-4)


def test_soft_and_stiff(
    robot: Robot, finish_experiment: Callable[[Experiment], dict[str, Result]]
) -> None:
    experiment = StiffnessOrFeedforward(quick=True)
    done = finish_experiment(experiment)
    section = experiment.report(done)
    _, pushed, *_ = section.tables
    for table in section.tables:
        assert all(len(cells) == len(table.head) for cells in table.rows)
    soft, stiff = pushed.rows
    # the same error both ways
    assert float(soft[2]) == pytest.approx(float(stiff[2]), rel=0.15)
    # the controller takes the mass m for 1.1 m: m x'' = F - 1.1 m (D x' + P x)
    taken = 1.1
    mass = robot.weight / 9.81 / taken
    for cells in (soft, stiff):
        P = float(cells[1].split("P = ")[1])
        D = 2 * np.sqrt(P)

        def motion(t: float, x: Any, P: float = P, D: float = D) -> list[float]:
            force = IMPULSE / PUSH_DURATION / mass if t < PUSH_DURATION else 0.0
            return [x[1], force - taken * (D * x[1] + P * x[0])]

        solution = solve_ivp(motion, (0, 2), [0.0, 0.0], max_step=2e-3)
        assert float(cells[3]) == pytest.approx(1e3 * solution.y[0].max(), rel=0.05)
    # from the stored deflection
    deflection = done["stiffness-ideal-soft_learned"].arrays["down/deflection"]
    assert float(soft[3]) == pytest.approx(-1e3 * deflection[:, 2].min(), rel=0.01)
    for figure in section.figures:
        plt.close(figure.draw())
