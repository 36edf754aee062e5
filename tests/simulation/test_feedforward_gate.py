from __future__ import annotations

import json
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Controller, Feedforward, PeriodicBasis, Robot, Run, Squat
from tsd_casadi.motions.motion import Reference
from tsd_casadi.repetition.compensator import Moment
from tsd_casadi.repetition.feedforward_gate import FADE, FeedforwardGate
from tsd_casadi.repetition.repetition import HOLD
from tsd_cli import command_line
from tsd_cli.actions import simulate
from tsd_clients import MujocoSimulator

DT = 1e-3
FREQUENCY = 1.0
SQUAT = Squat(0.03, FREQUENCY)
P, D = 50.0, 2 * math.sqrt(50.0)
Signal = Callable[[float], float]


def follow(d: Signal, u: Signal, laps: int = 3) -> tuple[float | None, list[float]]:
    """A double integrator with a gate; laps until the drop and all u applied."""
    gate = FeedforwardGate()
    gate.start(SimpleNamespace(axis=1, component=0, task="com", dt=DT))  # type: ignore[arg-type]
    e = rate = 0.0
    applied = []
    for tick in range(round((HOLD + laps / FREQUENCY) / DT)):
        time = tick * DT
        phase = math.pi + 2 * math.pi * FREQUENCY * max(time - HOLD, 0.0)
        lap = math.floor((time - HOLD) * FREQUENCY + 1e-9)
        moment: Any = Moment(
            time,
            phase,
            max(lap, -1),
            None,  # type: ignore[arg-type]
            Reference(0.0, 0.0, 0.0),
            u(phase),
            {"com.P": [P], "com.D": [D]},  # type: ignore[arg-type]
        )
        gate.before(moment)
        applied.append(moment.feedforward)
        moment.tick = SimpleNamespace(error=[math.nan, e])
        gate.after(moment)
        rate += DT * (d(phase) - moment.feedforward - D * rate - P * e)
        e += DT * rate
    dropped = gate.dropped_at
    return None if dropped is None else (dropped - HOLD) * FREQUENCY, applied


def rms_error(constant: float, sine: float, cosine: float) -> float:
    """In steady state, from the frequency response of e'' + D e' + P e = d."""
    omega = 2 * math.pi * FREQUENCY
    response = 1 / abs(P - omega**2 + 1j * omega * D)
    return math.hypot(constant / P, response * math.hypot(sine, cosine) / math.sqrt(2))


def signal(constant: float, sine: float, cosine: float) -> Signal:
    return lambda phase: constant + sine * math.sin(phase) + cosine * math.cos(phase)


accelerations = st.floats(-2.0, 2.0)
signals = st.tuples(accelerations, accelerations, accelerations)


@given(signals, signals)
def test_what_harms_is_dropped_within_a_lap(
    d: tuple[float, float, float], u: tuple[float, float, float]
) -> None:
    without = rms_error(*d)
    with_it = rms_error(*np.subtract(d, u))
    if with_it < 1.5 * without + 1e-3:
        return
    dropped, _ = follow(signal(*d), signal(*u), laps=2)
    assert dropped is not None
    assert dropped <= 1.3


@given(signals, st.floats(0.0, 1.8))
def test_a_share_of_what_is_needed_is_kept(d: tuple[float, float, float], share: float) -> None:
    u = tuple(share * each for each in d)
    dropped, applied = follow(signal(*d), signal(*u), laps=2)
    assert dropped is None
    assert applied[-1] == pytest.approx(signal(*u)(math.pi - 2 * math.pi * DT), abs=1e-9)


@pytest.mark.parametrize("factor", [-1.0, 3.0])
def test_the_wrong_sign_is_noticed_in_half_a_lap_and_faded_out(factor: float) -> None:
    dropped, applied = follow(lambda _: 1.0, lambda _: factor)
    assert dropped == pytest.approx(0.5, abs=0.01)
    after = round((HOLD + dropped / FREQUENCY) / DT)
    fading = np.abs(applied[after : after + round(FADE / DT) + 2])
    assert (np.diff(fading) <= 0).all()
    assert np.abs(np.diff(fading)).max() < 0.05
    assert applied[-1] == 0.0


def test_nothing_to_judge_is_kept() -> None:
    dropped, _ = follow(lambda _: 0.0, lambda _: 5e-4)
    assert dropped is None


def wrong_for(none: Run) -> Feedforward:
    """Of about the right size and the wrong sign."""
    basis = PeriodicBasis()
    return Feedforward(
        axes=("com.z",),
        basis=basis,
        weights=np.full((1, basis.L), 1.0 if none.log["feedback"][-1] < 0 else -1.0),
        standard_deviations=np.zeros((1, basis.L)),
        kind="generalised",
    )


@pytest.fixture(scope="module")
def none(robot: Robot, controller: Controller) -> Run:
    return MujocoSimulator(robot, 0.1).run(controller, SQUAT)


def test_a_run_goes_on_without_what_was_dropped(
    robot: Robot, controller: Controller, none: Run
) -> None:
    simulator, gate = MujocoSimulator(robot, 0.1), FeedforwardGate()
    run = simulator.run(controller, SQUAT, feedforward=wrong_for(none), compensators=[gate])
    assert gate.dropped_at is not None
    assert HOLD < gate.dropped_at < HOLD + 1 / SQUAT.frequency
    assert run.rms_error == pytest.approx(none.rms_error, rel=0.02)
    assert run.feedforward.kind == "none"
    # the same gate in another run starts anew
    simulator.run(controller, SQUAT, laps=2, compensators=[gate])
    assert gate.dropped_at is None


def test_simulate_says_what_it_dropped(
    none: Run, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(simulate, "_ask", lambda *_: wrong_for(none))
    arguments = "squat --controller local --frequency 1 --model-error 0.1 --laps 2 --json -"
    for choice, words in (("generalised", "dropped at 1.5"), ("learned", "")):
        command_line.app(
            ["simulate", *arguments.split(), "--feedforward", choice], standalone_mode=False
        )
        captured = capsys.readouterr()
        assert words in captured.err
        assert ("dropped" in captured.err) is bool(words)
        assert json.loads(captured.out)["feedforward"] == ("none" if words else "generalised")


def test_it_judges_the_borrowed_term_alone_and_drops_nothing_else() -> None:
    """Others that are asked after it add to the feedforward."""
    gate = FeedforwardGate()
    gate.start(SimpleNamespace(axis=0, component=0, task="com", dt=DT))  # type: ignore[arg-type]
    added, applied = 2.0, []
    e = rate = 0.0
    for tick in range(3000):
        phase = math.pi + 2 * math.pi * FREQUENCY * tick * DT
        moment: Any = Moment(
            tick * DT,
            phase,
            tick // 1000,
            None,  # type: ignore[arg-type]
            Reference(0.0, 0.0, 0.0),
            1.0,  # borrowed, of the wrong sign: it doubles the error
            {"com.P": [P], "com.D": [D]},  # type: ignore[arg-type]
        )
        gate.before(moment)
        moment.feedforward += added
        applied.append(moment.feedforward)
        moment.tick = SimpleNamespace(error=[e])
        gate.after(moment)
        # a disturbance of -1, and one that the others make up for
        rate += DT * (-1.0 + added - moment.feedforward - D * rate - P * e)
        e += DT * rate
    assert gate.dropped_at is not None
    assert applied[0] == 1.0 + added
    assert applied[-1] == added
