"""The gate on a double integrator: e'' + D e' + P e = d - u."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi.motions.motion import Reference
from tsd_casadi.repetition.compensator import Moment
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.repetition.phasing import FADE, SETTLED
from tsd_casadi.repetition.repetition import HOLD

DT = 2e-3
FREQUENCY = 1.0
P, D = 50.0, 2 * math.sqrt(50.0)
Signal = Callable[[float], float]


def gate_of(axes: int = 1, learned: int | None = None, stiffness: Sequence[float] = (P,)) -> Any:
    """A gate that was started, of axes with any gains; errors of other axes are no numbers."""
    gate = FeedforwardGate()
    gains = {"P": np.resize(stiffness, axes), "D": 2 * np.sqrt(np.resize(stiffness, axes))}
    gate.start(
        SimpleNamespace(  # type: ignore[arg-type]
            axes=("com.z", "com.x", "com.y")[:axes],
            motion=SimpleNamespace(frequency=FREQUENCY),
            index=np.arange(1, axes + 1),
            learned=axes if learned is None else learned,
            period=DT,
            gain=lambda command, name: gains[name],
        )
    )
    return gate


def moment_of(time: float, lap: int, u: Sequence[float]) -> Any:
    nothing, state = np.zeros(len(u)), None
    reference = Reference(nothing, nothing, nothing)
    offered = np.array(u, dtype=float)
    share = min(time * FREQUENCY, 1.0)
    return Moment(
        time,
        0.0,
        lap,
        state,
        reference,
        share * offered,
        state,
        offered=offered,
        share=share,  # type: ignore[arg-type]
    )


def answer(moment: Any, error: Sequence[float]) -> None:
    """A tick whose first error belongs to an axis that is not of the repetition."""
    moment.tick = SimpleNamespace(error=np.array([math.nan, *error]))


class Followed:
    """A double integrator behind a gate; times are in laps of the motion."""

    def __init__(
        self,
        d: Callable[[float, float], float],
        u: Signal,
        laps: float = 3,
        others: int = 0,
        added: float = 0.0,
        stiffness: float = P,
        end: float = -math.inf,
    ) -> None:
        """Run.

        Args:
            d: Of phase and time in laps.
            u: Of the phase.
            others: Further axes, with neither an error nor a feedforward.
            added: By somebody who is asked after the gate, and does not need it.
            stiffness: Of the critically damped loop.
            end: No error is less: the joints end there.
        """
        self.gate, damping = gate_of(1 + others, stiffness=[stiffness]), 2 * math.sqrt(stiffness)
        self.applied: list[float] = []
        self.drops: list[float] = []
        self.returns: list[float] = []
        self.errors: list[float] = []
        e = rate = 0.0
        was: float | None = None
        rest = [0.0] * others
        for tick in range(round((HOLD + laps / FREQUENCY) / DT)):
            time = tick * DT
            now = (time - HOLD) * FREQUENCY
            phase = math.pi + 2 * math.pi * max(now, 0.0)
            moment = moment_of(time, max(math.floor(now + 1e-9), -1), [*rest, u(phase)])
            self.gate.before(moment)
            moment.feedforward[-1] += added
            self.applied.append(float(moment.feedforward[-1]))
            answer(moment, [*rest, e])
            self.gate.after(moment)
            rate += DT * (d(phase, now) + added - self.applied[-1] - damping * rate - stiffness * e)
            e += DT * rate
            if e < end:
                e, rate = end, 0.0
            self.errors.append(e)
            if self.gate.dropped_at != was:
                (self.returns if was is not None else self.drops).append(now)
                was = self.gate.dropped_at

    def full_from(self, term: float) -> float:
        """Since when all of a constant term has been in use."""
        less = np.flatnonzero(np.abs(np.array(self.applied) - term) > 1e-9)
        return ((int(less[-1]) + 1) * DT - HOLD) * FREQUENCY


def always(d: Signal) -> Callable[[float, float], float]:
    return lambda phase, _: d(phase)


def rms_error(constant: float, sine: float, cosine: float) -> float:
    """In steady state, from the frequency response of e'' + D e' + P e = d."""
    omega = 2 * math.pi * FREQUENCY
    response = 1 / abs(P - omega**2 + 1j * omega * D)
    return math.hypot(constant / P, response * math.hypot(sine, cosine) / math.sqrt(2))


def signal(constant: float, sine: float, cosine: float) -> Signal:
    return lambda phase: constant + sine * math.sin(phase) + cosine * math.cos(phase)


accelerations = st.floats(-2.0, 2.0)
signals = st.tuples(accelerations, accelerations, accelerations)


@settings(max_examples=40)
@given(signals, signals)
def test_what_harms_is_dropped_within_a_lap_and_stays_out(
    d: tuple[float, float, float], u: tuple[float, float, float]
) -> None:
    without = rms_error(*d)
    with_it = rms_error(*np.subtract(d, u))
    if with_it < 1.5 * without + 1e-3:
        return
    seen = Followed(always(signal(*d)), signal(*u), laps=3)
    # on the whole: what looked good in half a lap is soon known better
    used = np.abs(seen.applied[-round(1 / FREQUENCY / DT) :])
    assert seen.drops
    assert seen.drops[0] <= 1.0
    assert seen.gate.dropped_at is not None or used.min() == 0.0


@settings(max_examples=40)
@given(signals, st.floats(0.05, 1.8))
def test_a_share_of_what_is_needed_is_kept(d: tuple[float, float, float], share: float) -> None:
    seen = Followed(always(signal(*d)), signal(*(share * each for each in d)), laps=2)
    assert not seen.drops
    assert seen.gate.veto is None
    expected = share * signal(*d)(math.pi - 2 * math.pi * DT)
    assert seen.applied[-1] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("factor", [-0.5, -1.0, -5.0])
def test_what_has_the_wrong_sign_is_dropped_while_standing_and_faded_out(factor: float) -> None:
    seen = Followed(always(lambda _: 1.0), lambda _: factor)
    (dropped,) = seen.drops
    assert dropped == pytest.approx(-0.5, abs=0.01)
    assert not seen.returns
    after = round((HOLD + dropped / FREQUENCY) / DT)
    fading = np.abs(seen.applied[after : after + round(FADE / DT) + 2])
    assert np.abs(np.diff(fading)).max() < 0.03 * abs(factor)
    assert not np.any(seen.applied[after + round(FADE / DT) + 1 :])
    # never more than was phased in until then
    assert np.abs(seen.applied).max() < 0.55 * abs(factor)


@pytest.mark.parametrize("factor", [3.0, 6.0])
def test_what_is_too_much_is_dropped_as_soon_as_more_of_it_is_in_use(factor: float) -> None:
    seen = Followed(always(lambda _: 1.0), lambda _: factor)
    assert -0.5 < seen.drops[0] <= 0.5
    assert not seen.returns


def test_a_robot_that_friction_holds_says_nothing_of_the_term_while_standing() -> None:
    """Nothing moves before the motion, whatever is fed forward."""

    def d(_: float, now: float) -> float:
        return 1.0 if now > 0 else share(now)

    def share(now: float) -> float:
        return min(1 + now / (HOLD * FREQUENCY), 1.0)  # what moment_of lets through

    seen = Followed(d, lambda _: 1.0, laps=3)
    assert not seen.drops


def test_what_is_wrong_in_the_motion_only_is_dropped_within_a_lap() -> None:
    # the right mean; standing still it does nothing
    seen = Followed(always(lambda _: 0.3), lambda phase: 0.3 - 3 * math.sin(phase))
    assert 0 < seen.drops[0] <= 1.0


def test_what_harms_in_a_quarter_of_each_lap_is_tried_once_more_but_not_in_full() -> None:
    def pulse(phase: float) -> float:
        return 1.0 + (5.0 if math.cos(phase) > math.cos(math.pi / 4) else 0.0)

    seen = Followed(always(lambda _: 1.0), pulse, laps=12)
    assert seen.drops[0] <= 1.0
    assert len(seen.drops) <= 2
    assert seen.gate.dropped_at is not None
    after = round((HOLD + seen.drops[0] / FREQUENCY + FADE) / DT)
    assert np.abs(seen.applied[after:]).max() < 0.6 * 6.0


def test_nothing_to_judge_is_kept() -> None:
    assert not Followed(always(lambda _: 0.0), lambda _: 5e-3).drops
    # a fifth of a millimetre is something
    assert Followed(always(lambda _: 0.0), lambda _: 1e-2).drops


@pytest.mark.parametrize(
    ("acceleration", "duration"),
    [(-8.0, 0.1), (8.0, 0.1), (-16.0, 0.05), (-1.0, 0.5), (-1.0, 1.0), (-1.0, 2.0), (-3.0, 1.5)],
)
@pytest.mark.parametrize("start", [2.0, 2.4, 2.7])
def test_a_push_is_forgiven(acceleration: float, duration: float, start: float) -> None:
    def d(_: float, now: float) -> float:
        return 1.0 + (acceleration if start <= now < start + duration else 0.0)

    seen = Followed(d, lambda _: 1.0, laps=math.ceil(start + duration + 2.4))
    assert len(seen.drops) <= 1
    assert seen.gate.veto is None
    assert seen.full_from(1.0) <= start + duration + 2.0
    # of 20 mm without the term
    assert abs(seen.errors[-1]) < 1e-3


def test_one_that_comes_back_is_phased_in_over_a_lap() -> None:
    seen = Followed(lambda _, now: 0.0 if 2 <= now < 4 else 1.0, lambda _: 1.0, laps=7)
    (back,) = seen.returns
    first = round((HOLD + back / FREQUENCY) / DT) + 1
    lap = round(1 / FREQUENCY / DT)
    rising = np.array(seen.applied[first : first + lap])
    assert (np.diff(rising) >= 0).all()
    assert np.diff(rising).max() < 1.6 / lap
    assert seen.full_from(1.0) == pytest.approx(back + 1, abs=0.01)


def test_a_load_that_goes_for_good_takes_the_term_with_it() -> None:
    seen = Followed(lambda _, now: 1.0 if now < 2 else 0.0, lambda _: 1.0, laps=8)
    assert len(seen.drops) == 1
    assert not seen.returns
    assert seen.drops[0] - 2 < 1


class Deceiving:
    """Needs all of the term whenever it is out of use, and none of it when it is in use."""

    def __init__(self) -> None:
        self.in_use = True

    def __call__(self, phase: float, now: float) -> float:
        return 0.0 if self.in_use else 1.0


def test_retries_become_rare_where_the_prediction_is_wrong_every_time() -> None:
    deceiving = Deceiving()
    original = FeedforwardGate.before

    def before(gate: FeedforwardGate, moment: Moment) -> None:
        original(gate, moment)
        deceiving.in_use = gate.dropped_at is None

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FeedforwardGate, "before", before)
        seen = Followed(deceiving, lambda _: 1.0, laps=40)
    pauses = np.subtract(seen.returns, seen.drops[: len(seen.returns)])
    # each further one at least nearly twice as long, half a lap of looking included
    assert len(seen.drops) <= 7
    assert pauses[-1] > 6
    assert (np.diff(pauses[1:]) > 0.5).all()


def test_earlier_drops_are_forgiven_after_laps_that_went_well() -> None:
    def d(_: float, now: float) -> float:
        return (
            0.0 if now > 0 and now % 10 >= 8 else 1.0
        )  # a force that takes the load, every ten laps

    seen = Followed(d, lambda _: 1.0, laps=38)
    assert len(seen.drops) == 3
    ends = np.array([10.0, 20.0, 30.0])
    assert (np.subtract(seen.returns, ends) < 1).all()


@pytest.mark.parametrize("others", [0, 2])
@pytest.mark.parametrize("factor", [-1.0, 0.5])
def test_axes_without_an_error_change_nothing(factor: float, others: int) -> None:
    alone = Followed(always(lambda _: 1.0), lambda _: factor)
    together = Followed(always(lambda _: 1.0), lambda _: factor, others=others)
    assert together.drops == alone.drops
    assert bool(alone.drops) == (factor < 0)


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
    for tick in range(round(2 / DT)):
        moment = moment_of(1 + tick * DT, tick // round(1 / DT), [0.0, 0.0])
        gate.before(moment)
        # errors that u is said to have made: the first smaller, the second larger
        for moved in (gate._applied, gate._whole):
            moved.x, moved._rate = np.array([5e-3, -5e-3]), np.zeros(2)
        answer(moment, [5e-3, 1e-2])
        gate.after(moment)
    assert (gate.drops > 0) == drops


def test_axes_that_only_move_are_neither_judged_nor_spared() -> None:
    gate = gate_of(2, learned=1)
    for tick in range(round(3 / DT)):
        moment = moment_of(tick * DT, tick // round(1 / DT), [-1.0, 0.5])
        gate.before(moment)
        answer(moment, [2 / P, math.nan])
        gate.after(moment)
    assert gate.dropped_at is not None
    assert not moment.feedforward.any()


def test_it_judges_the_borrowed_term_alone_and_drops_nothing_else() -> None:
    # of the wrong sign; whoever is asked after it adds 2, which is needed
    seen = Followed(always(lambda _: -1.0), lambda _: 1.0, added=2.0)
    assert seen.drops
    assert seen.applied[0] == 2.0
    assert seen.applied[-1] == 2.0


def test_it_says_what_it_saw_and_what_it_predicts() -> None:
    standing = Followed(always(lambda _: 1.0), lambda _: -1.0).gate
    assert standing.veto is not None
    assert "with what was in use of it" in standing.veto
    dropped = Followed(always(lambda _: 1.0), lambda _: 3.0).gate
    assert dropped.remarks == ()
    assert dropped.veto is not None
    # nearly 2 / 50, and 1 / 50
    assert "the borrowed feedforward was dropped at 1.50 s: an RMS error of 39" in dropped.veto
    assert "mm with all of it, 20 mm without" in dropped.veto
    assert "is predicted" in dropped.veto
    assert "guess" not in dropped.veto
    kept = Followed(always(lambda _: 1.0), lambda _: 0.5).gate
    assert kept.veto is None
    # 0.5 / 50 and 1 / 50
    assert kept.remarks == (
        "the borrowed feedforward was kept: an RMS error of 10 mm with it, 20 mm predicted without",
    )


@pytest.mark.parametrize(("lack", "is_far"), [(2.45, False), (2.55, True)])
def test_far_off_it_says_that_it_guesses(lack: float, is_far: bool) -> None:
    (remark,) = Followed(always(lambda _: lack), lambda _: lack).gate.remarks
    assert ("that is a guess" in remark) == is_far


# at P = 5 a robot that needs -0.75 m/s^2 would be 15 cm too high, but its knees are straight at 11
SOFT = {"stiffness": 5.0, "end": -0.11}


@pytest.mark.parametrize("factor", [1.8, 1.9])
def test_far_off_what_harms_is_found_out_by_a_lap_without_it(factor: float) -> None:
    """The predicted error without it is larger than that with it, the real one is smaller."""
    seen = Followed(always(lambda _: -0.75), lambda _: -0.75 * factor, laps=8, **SOFT)
    (dropped,) = seen.drops
    assert dropped <= 1.0
    assert not seen.returns
    assert seen.gate.veto is not None
    assert "tried without" in seen.gate.veto
    assert "that is a guess" in seen.gate.veto
    assert abs(seen.errors[-1]) == pytest.approx(0.11)


@pytest.mark.parametrize("factor", [0.8, 1.0, 1.3, 1.6])
def test_far_off_what_clearly_helps_is_not_tried(factor: float) -> None:
    seen = Followed(always(lambda _: -0.75), lambda _: -0.75 * factor, laps=8, **SOFT)
    assert not seen.drops


@pytest.mark.parametrize("factor", [0.3, 1.75])
def test_what_helps_after_all_comes_back_from_the_trial_and_is_tried_no_more(factor: float) -> None:
    # nothing ends: the prediction was right
    seen = Followed(always(lambda _: -0.75), lambda _: -0.75 * factor, laps=20, stiffness=5.0)
    assert len(seen.drops) == len(seen.returns) == 1
    # when the loop has settled, a lap
    settled = SETTLED / math.sqrt(5.0) * FREQUENCY
    assert seen.returns[0] - seen.drops[0] == pytest.approx(settled + 1.0, abs=0.1)
    assert any("came back" in remark for remark in seen.gate.remarks)


@pytest.mark.parametrize(("lack", "tried"), [(2.4, False), (2.6, True)])
def test_near_the_reference_the_prediction_counts(lack: float, tried: bool) -> None:
    seen = Followed(always(lambda _: lack), lambda _: 1.75 * lack)
    assert bool(seen.drops) == tried


@pytest.mark.parametrize(("factor", "tried"), [(1.64, False), (1.70, True)])
def test_a_guess_speaks_clearly_where_half_as_much_again_would_still_do(
    factor: float, tried: bool
) -> None:
    seen = Followed(always(lambda _: -0.75), lambda _: -0.75 * factor, stiffness=5.0)
    assert bool(seen.drops) == tried


def test_a_gate_starts_anew_with_each_repetition() -> None:
    gate = Followed(always(lambda _: 1.0), lambda _: -1.0).gate
    assert gate.veto is not None
    gate.start(gate._setting)
    assert (gate.veto, gate.drops, gate.remarks) == (None, 0, ())
