from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
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


def gate_of(axes: int = 1, learned: int | None = None, stiffness: Sequence[float] = (P,)) -> Any:
    """A gate that was started, of axes with any gains; errors of other axes are no numbers."""
    gate = FeedforwardGate()
    gains = {"P": np.resize(stiffness, axes), "D": 2 * np.sqrt(np.resize(stiffness, axes))}
    gate.start(
        SimpleNamespace(  # type: ignore[arg-type]
            index=np.arange(1, axes + 1),
            learned=axes if learned is None else learned,
            period=DT,
            gain=lambda command, name: gains[name],
        )
    )
    return gate


def moment_of(time: float, phase: float, lap: int, u: Sequence[float]) -> Any:
    nothing = np.zeros(len(u))
    reference = Reference(nothing, nothing, nothing)
    state: Any = None
    return Moment(time, phase, lap, state, reference, np.array(u, dtype=float), state)


def answer(moment: Any, error: Sequence[float]) -> None:
    """A tick whose first error belongs to an axis that is not of the repetition."""
    moment.tick = SimpleNamespace(error=np.array([math.nan, *error]))


def follow(
    d: Signal, u: Signal, laps: int = 3, others: int = 0
) -> tuple[float | None, list[float]]:
    """A double integrator with a gate; laps until the drop and all u applied.

    Other axes have neither an error nor a feedforward.
    """
    gate = gate_of(1 + others)
    e = rate = 0.0
    applied = []
    rest = [0.0] * others
    for tick in range(round((HOLD + laps / FREQUENCY) / DT)):
        time = tick * DT
        phase = math.pi + 2 * math.pi * FREQUENCY * max(time - HOLD, 0.0)
        lap = math.floor((time - HOLD) * FREQUENCY + 1e-9)
        moment = moment_of(time, phase, max(lap, -1), [*rest, u(phase)])
        gate.before(moment)
        applied.append(float(moment.feedforward[-1]))
        answer(moment, [*rest, e])
        gate.after(moment)
        rate += DT * (d(phase) - applied[-1] - D * rate - P * e)
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


@pytest.mark.parametrize("others", [0, 2])
@pytest.mark.parametrize("factor", [-1.0, 0.5])
def test_axes_without_an_error_change_nothing(factor: float, others: int) -> None:
    alone, applied = follow(lambda _: 1.0, lambda _: factor)
    together, with_others = follow(lambda _: 1.0, lambda _: factor, others=others)
    assert (together is None) == (alone is None) == (factor > 0)
    if alone is not None:
        # the same sum over more axes has to harm more than so many times nothing
        assert together == pytest.approx(alone, abs=0.02)
        assert with_others[-1] == applied[-1] == 0.0


@pytest.mark.parametrize(
    ("stiffness", "drops"),
    [
        # the second axis is tracked worse by as much as the first one is tracked better
        ((50.0, 200.0), True),
        ((200.0, 50.0), False),
    ],
)
def test_axes_count_as_the_feedback_counts_them(
    stiffness: tuple[float, float], drops: bool
) -> None:
    gate = gate_of(2, stiffness=stiffness)
    for tick in range(2000):
        moment = moment_of(tick * DT, 2 * math.pi * FREQUENCY * tick * DT, tick // 1000, [0.0, 0.0])
        gate.before(moment)
        # errors that u is said to have made: the first smaller, the second larger
        gate._moved = np.array([5e-3, -5e-3])
        gate._rate = np.zeros(2)
        answer(moment, [5e-3, 1e-2])
        gate.after(moment)
    assert (gate.dropped_at is not None) == drops


def test_axes_that_only_move_are_neither_judged_nor_spared() -> None:
    gate = gate_of(2, learned=1)
    for tick in range(3000):
        moment = moment_of(
            tick * DT, 2 * math.pi * FREQUENCY * tick * DT, tick // 1000, [-1.0, 0.0]
        )
        gate.before(moment)
        answer(moment, [2 / P, math.nan])
        gate.after(moment)
    assert gate.dropped_at is not None
    assert not moment.feedforward.any()


def test_a_gate_says_when_and_why() -> None:
    gate = gate_of()
    assert gate.veto is None
    gate.dropped_at = 1.5
    assert gate.veto.startswith("the feedforward was dropped at 1.50 s")
    gate.start(SimpleNamespace(index=np.arange(1), learned=1))  # type: ignore[arg-type]
    assert gate.veto is None


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
    assert HOLD < gate.dropped_at < HOLD + 1 / SQUAT.frequency
    assert run.errors["com.z"].rms == pytest.approx(none.errors["com.z"].rms, rel=0.02)
    assert run.feedforward.kind == "none"
    assert run.vetoes == [gate.veto]
    # the same gate in another run starts anew
    simulator.run(controller, SQUAT, laps=2, compensators=[gate])
    assert gate.dropped_at is None


def test_simulate_says_what_it_dropped(
    none: Run, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(simulate, "_ask", lambda *_: wrong_for(none))
    words = "simulate squat --controller local --amplitude 0.03 --frequency 1 --axes com.z"
    words += " --model-error 0.1 --laps 2 --json -"
    for choice, said in (("generalised", "dropped at 1.5"), ("learned", "")):
        arguments = [*words.split(), "--feedforward", choice]
        command_line.app_for(arguments)(arguments, standalone_mode=False)
        captured = capsys.readouterr()
        assert said in captured.err
        assert ("dropped" in captured.err) is bool(said)
        assert json.loads(captured.out)["feedforward"] == ("none" if said else "generalised")


def test_it_judges_the_borrowed_term_alone_and_drops_nothing_else() -> None:
    """Others that are asked after it add to the feedforward."""
    gate = gate_of()
    added, applied = 2.0, []
    e = rate = 0.0
    for tick in range(3000):
        phase = math.pi + 2 * math.pi * FREQUENCY * tick * DT
        # borrowed, of the wrong sign: it doubles the error
        moment = moment_of(tick * DT, phase, tick // 1000, [1.0])
        gate.before(moment)
        moment.feedforward += added
        applied.append(float(moment.feedforward[0]))
        answer(moment, [e])
        gate.after(moment)
        # a disturbance of -1, and one that the others make up for
        rate += DT * (-1.0 + added - applied[-1] - D * rate - P * e)
        e += DT * rate
    assert gate.dropped_at is not None
    assert applied[0] == 1.0 + added
    assert applied[-1] == added
