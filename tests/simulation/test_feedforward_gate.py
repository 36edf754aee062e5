"""The gate in simulated repetitions; on a double integrator see the unit tests."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tsd_casadi import Controller, Feedforward, PeriodicBasis, Robot, Run, Squat
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.repetition.repetition import HOLD
from tsd_cli import command_line
from tsd_cli.actions import simulate
from tsd_clients import MujocoSimulator

SQUAT = Squat(0.03, 1.0)


def wrong_for(none: Run) -> Feedforward:
    """Of about the right size and the wrong sign."""
    basis = PeriodicBasis()
    return Feedforward(
        axes=("com.z",),
        basis=basis,
        weights=np.full((1, basis.L), 1.0 if none.along("feedback", "com.z")[-1] < 0 else -1.0),
        standard_deviations=np.zeros((1, basis.L)),
        kind="generalised",
    )


@pytest.fixture(scope="module")
def none(robot: Robot, controller: Controller) -> Run:
    return MujocoSimulator(robot, 0.1).run(controller, SQUAT, axes=("com.z",))


@pytest.mark.parametrize("axes", [("com.z",), ("com.z", "com.x", "com.y")])
def test_a_run_goes_on_without_what_was_dropped(
    robot: Robot, controller: Controller, none: Run, axes: tuple[str, ...]
) -> None:
    simulator, gate = MujocoSimulator(robot, 0.1), FeedforwardGate()
    run = simulator.run(
        controller, SQUAT, axes=axes, feedforward=wrong_for(none), compensators=[gate]
    )
    assert gate.dropped_at is not None
    # standing, before all of it was in use
    assert gate.dropped_at < HOLD
    assert run.errors["com.z"].rms == pytest.approx(none.errors["com.z"].rms, rel=0.02)
    assert run.feedforward.kind == "none"
    assert run.vetoes == [gate.veto]
    # the same gate in another run starts anew
    simulator.run(controller, SQUAT, laps=2, compensators=[gate])
    assert gate.dropped_at is None


def test_simulate_says_what_it_dropped(
    none: Run, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = wrong_for(none)
    monkeypatch.setattr(simulate, "_ask", lambda choice, *_: replace(wrong, kind=choice.value))
    words = "simulate squat --controller local --amplitude 0.03 --frequency 1 --axes com.z"
    words += " --model-error 0.1 --laps 2 --json -"
    for choice, said in (("generalised", "dropped at 0."), ("learned", "")):
        arguments = [*words.split(), "--feedforward", choice]
        command_line.app_for(arguments)(arguments, standalone_mode=False)
        captured = capsys.readouterr()
        assert said in captured.err
        assert ("dropped" in captured.err) is bool(said)
        assert json.loads(captured.out)["feedforward"] == ("none" if said else choice)
