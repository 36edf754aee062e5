from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import IncompatibleEntry
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import find_rule

BASIS = PeriodicBasis()
CONTEXT = Context("00ff", "abcd")
KEY = EntryKey.of(
    "hermes_lower", "squat", "1", ("com.z",), {"amplitude": 0.03, "frequency": 0.25}, CONTEXT
)
MADE = Circumstances({"P": [50.0], "D": [14.0]}, {"hardware": "ideal"}, "0.1.0")
PHASE = np.pi + np.linspace(0, 2 * np.pi, 100, endpoint=False)
NOTHING = np.zeros((1, BASIS.L))


def recording(
    applied: np.ndarray = NOTHING, error: float = 1e-3, feedback: float = 0.5, **changes: Any
) -> Recording:
    """One repetition whose feedback was constant, so fitted weights equal it."""
    made = {
        "key": KEY,
        "basis": BASIS,
        "applied": applied,
        "laps": [Lap(PHASE, np.full((1, 100), feedback))] * 2,
        "errors": {"com.z": AxisError(error, ac_rms=error / 10)},
        "circumstances": MADE,
    }
    return Recording(**{**made, **changes})


def measured(error: float) -> dict[str, AxisError]:
    """What is noted of such a repetition: two laps that do not differ."""
    return {"com.z": AxisError(error, ac_rms=error / 10, laps=2, scatter=0.0)}


def told(rule: str = "guarded", **changes: bool) -> Instruction:
    return Instruction(find_rule(rule), **changes)


def empty_entry() -> Entry:
    return Entry(KEY, BASIS, MADE)


def entry_after(*errors: float, rule: str = "guarded") -> Entry:
    """An entry whose served weights were used once for each error, in turn."""
    entry = empty_entry()
    entry.add(recording(error=errors[0]), told(rule))
    for error in errors[1:]:
        entry.add(recording(entry.served.weights, error), told(rule))
    return entry


def numbers(entry: Entry) -> list[int]:
    return [iteration.number for iteration in entry.iterations]


def test_first_recording_is_iteration_zero_and_makes_iteration_one() -> None:
    entry = empty_entry()
    notes = entry.add(recording(error=2e-3, feedback=0.5))
    assert notes == []
    assert numbers(entry) == [0, 1]
    assert entry.iterations[0].errors == measured(2e-3)
    assert not entry.iterations[0].weights.any()
    assert entry.iterations[1].errors is None
    np.testing.assert_allclose(entry.iterations[1].weights, 0.5, atol=1e-7)


def test_newest_untested_iteration_is_served() -> None:
    entry = entry_after(2e-3)
    assert (entry.served.number, entry.best.number) == (1, 0)


def test_tested_and_better_goes_on_from_there() -> None:
    entry = empty_entry()
    entry.add(recording(error=2e-3, feedback=0.5))
    entry.add(recording(entry.served.weights, error=1e-3, feedback=0.1))
    assert (entry.served.number, entry.best.number, entry.learning_gain) == (2, 1, 1.0)
    np.testing.assert_allclose(entry.served.weights, 0.6, atol=1e-7)


def test_what_proves_worse_is_dropped_for_the_best_and_the_gain_halved() -> None:
    entry = entry_after(2e-3, 1e-3)
    notes = entry.add(recording(entry.served.weights, error=3e-3))
    assert (entry.served.number, entry.best.number, entry.learning_gain) == (1, 1, 0.5)
    assert numbers(entry) == [0, 1, 2]  # nothing is learned from the worse one
    assert entry.iterations[2].errors is not None
    (note,) = notes
    for part in ("iteration 2 is worse than iteration 1", "3 mm", "1 mm", "gain now 0.5"):
        assert part in note


def test_after_a_worse_one_learning_goes_on_from_the_best_with_half_the_gain() -> None:
    entry = entry_after(2e-3, 1e-3, 3e-3)
    base = entry.served.weights
    entry.add(recording(base, error=1e-3))
    assert entry.served.number == 3
    np.testing.assert_allclose(entry.served.weights, base + 0.5 * 0.5, atol=1e-7)


def test_gain_is_halved_again_each_time() -> None:
    entry = entry_after(1e-3, 2e-3, 1e-3, 2e-3, 1e-3, 2e-3)
    assert entry.learning_gain == 0.125
    assert entry.served.number == 0


def test_best_of_several_is_served_after_a_worse_one() -> None:
    entry = entry_after(4e-3, 1e-3, 2e-3)
    assert entry.served.number == 1
    np.testing.assert_array_equal(entry.served.weights, entry.iterations[1].weights)


def test_equal_error_is_not_worse() -> None:
    entry = entry_after(1e-3, 1e-3)
    assert (entry.learning_gain, entry.served.number) == (1.0, 2)


def test_a_hair_worse_is_worse() -> None:
    entry = entry_after(1e-3, 1e-3 * (1 + 1e-12))
    assert (entry.learning_gain, entry.served.number) == (0.5, 0)


def test_plain_rule_goes_on_from_what_proved_worse() -> None:
    entry = empty_entry()
    entry.add(recording(error=1e-3, feedback=0.5), told("plain"))
    notes = entry.add(recording(entry.served.weights, 5e-3, 0.25), told("plain"))
    assert notes == []
    assert (entry.served.number, entry.best.number, entry.learning_gain) == (2, 0, 1.0)
    np.testing.assert_allclose(entry.served.weights, 0.75, atol=1e-7)


def test_plain_rule_serves_the_newest_though_tested_and_worse() -> None:
    entry = entry_after(1e-3, rule="plain")
    entry.add(recording(entry.served.weights, 5e-3), told("plain", update=False))
    assert (entry.served.number, entry.best.number) == (1, 0)


def test_plain_rule_is_the_papers_sum_with_full_gain_after_a_halving() -> None:
    entry = entry_after(1e-3, 2e-3)
    assert entry.learning_gain == 0.5
    entry.add(recording(entry.served.weights, 1e-3, 0.5), told("plain"))
    np.testing.assert_allclose(entry.served.weights, 0.5, atol=1e-7)


def test_guarded_after_plain_serves_the_best_again() -> None:
    entry = entry_after(1e-3, 5e-3, rule="plain")
    entry.add(recording(entry.served.weights, 4e-3), told("guarded"))
    assert (entry.served.number, entry.learning_gain) == (0, 0.5)


def test_without_update_only_the_errors_are_noted() -> None:
    entry = entry_after(2e-3)
    entry.add(recording(entry.served.weights, 1e-3), told(update=False))
    assert numbers(entry) == [0, 1]
    assert entry.served.number == 1
    assert entry.served.errors == measured(1e-3)


def test_without_update_a_worse_one_still_gives_way_to_the_best() -> None:
    entry = entry_after(2e-3)
    notes = entry.add(recording(entry.served.weights, 3e-3), told(update=False))
    assert (entry.served.number, entry.learning_gain, len(notes)) == (0, 0.5, 1)


def test_weights_applied_from_elsewhere_become_an_iteration_of_their_own() -> None:
    entry = entry_after(2e-3)
    foreign = np.full((1, BASIS.L), 0.3)
    entry.add(recording(foreign, 1e-3, 0.1))
    assert numbers(entry) == [0, 1, 2, 3]
    np.testing.assert_array_equal(entry.iterations[2].weights, foreign)
    assert entry.iterations[1].errors is None
    np.testing.assert_allclose(entry.served.weights, 0.4, atol=1e-7)


def test_entry_may_start_from_generalised_weights() -> None:
    entry = empty_entry()
    foreign = np.full((1, BASIS.L), 0.3)
    entry.add(recording(foreign, 1e-3, 0.1))
    assert numbers(entry) == [0, 1, 2]
    assert entry.iterations[0].errors is None
    assert entry.best.number == 1
    assert entry.served.number == 2


def test_repeating_an_iteration_replaces_its_errors() -> None:
    entry = entry_after(2e-3, 1e-3)
    used = entry.iterations[1].weights
    entry.add(recording(used, 0.5e-3), told(update=False))
    assert numbers(entry) == [0, 1, 2]
    assert entry.iterations[1].error == pytest.approx(50.0 * 0.5e-3)


@given(st.lists(st.floats(1e-6, 1e-1), min_size=1, max_size=10))
def test_served_is_untested_or_the_best_whatever_the_errors(errors: list[float]) -> None:
    entry = entry_after(*errors)
    tested = [i for i in entry.iterations if i.errors is not None]
    assert entry.served.errors is None or entry.served.error == min(i.error for i in tested)
    assert numbers(entry) == list(range(len(entry.iterations)))
    assert 0 < entry.learning_gain <= 1
    assert np.log2(entry.learning_gain) == round(np.log2(entry.learning_gain))


@pytest.mark.parametrize("overreaction", [0.7, 1.5, 3.0, 10.0])
def test_guarded_learning_converges_where_the_plain_sum_diverges(overreaction: float) -> None:
    # feedback = overreaction * what is missing: plain contracts by 1 - overreaction
    missing = 1.0

    def repeat(rule: str) -> list[float]:
        entry, applied, errors = empty_entry(), NOTHING, []
        for _ in range(14):
            left = missing - float(applied[0, 0])
            errors.append(abs(left))
            entry.add(recording(applied, abs(left), overreaction * left), told(rule))
            applied = entry.served.weights
        return errors

    plain, guarded = repeat("plain"), repeat("guarded")
    assert plain[-1] == pytest.approx(abs(1 - overreaction) ** 13, rel=1e-3, abs=1e-6)
    assert guarded[-1] < 0.02
    best = np.minimum.accumulate(guarded)
    assert max(np.array(guarded[1:]) - best[:-1] * max(1, overreaction - 1)) < 1e-6


def test_another_basis_is_refused() -> None:
    entry = entry_after(1e-3)
    other = PeriodicBasis.of_size(10)
    with pytest.raises(IncompatibleEntry, match=r"L = 25.*L = 10.*restart"):
        entry.add(recording(np.zeros((1, 10)), basis=other))
    with pytest.raises(IncompatibleEntry, match="width"):
        entry.add(recording(basis=PeriodicBasis(25, 60.0)))


@pytest.mark.parametrize("part", ["robot", "motion", "version", "context"])
def test_a_recording_of_another_key_is_refused(part: str) -> None:
    entry = entry_after(1e-3)
    value = Context("00ff", "0100") if part == "context" else "other"
    with pytest.raises(IncompatibleEntry, match=r"another robot, motion, .* or context"):
        entry.add(recording(key=replace(KEY, **{part: value})))


def test_a_refused_recording_changes_nothing() -> None:
    entry = entry_after(1e-3)
    before = (numbers(entry), entry.circumstances, entry.rule, entry.served.number)
    for changes in (
        {"key": replace(KEY, context=Context("00ff", "0100"))},
        {"basis": PeriodicBasis(25, 60.0)},
    ):
        with pytest.raises(IncompatibleEntry):
            entry.add(recording(entry.served.weights, **changes), told("plain"))
    assert (numbers(entry), entry.circumstances, entry.rule, entry.served.number) == before


def test_other_gains_are_reported_and_taken() -> None:
    entry = entry_after(1e-3)
    other = replace(MADE, gains={"P": [25.0], "D": [14.0]})
    (note,) = entry.add(recording(entry.served.weights, 0.5e-3, circumstances=other))
    assert "gains differ" in note
    assert "25.0" in note
    assert "50.0" in note
    assert entry.circumstances == other
    assert entry.served.number == 2


def test_another_setting_is_taken() -> None:
    entry = entry_after(1e-3)
    other = replace(MADE, setting={**MADE.setting, "seed": 7})
    assert entry.add(recording(entry.served.weights, 0.5e-3, circumstances=other)) == []
    assert entry.circumstances.setting == {**MADE.setting, "seed": 7}
    assert entry.iterations[0].circumstances == MADE


def test_another_version_of_the_software_is_no_reason_for_a_remark() -> None:
    entry = entry_after(1e-3)
    other = replace(MADE, version="9.9")
    assert entry.add(recording(entry.served.weights, 0.5e-3, circumstances=other)) == []


def test_feedforward_says_where_it_comes_from() -> None:
    entry = entry_after(2e-3, 1e-3)
    entry.identifier, entry.updated = 7, "2026-01-01T00:00:00+00:00"
    untested = entry.feedforward()
    assert (untested.kind, untested.iteration, untested.axes) == ("learned", 2, ("com.z",))
    assert untested.parameters == {"amplitude": 0.03, "frequency": 0.25}
    assert untested.provenance["tested"] is False
    assert untested.provenance["entries"] == [7]
    assert untested.provenance["gains"] == MADE.gains
    context = {"body": "00ff", "formulation": "abcd", "correction": ""}
    assert untested.provenance["context"] == context
    assert untested.provenance["axes"] == ["com.z"]
    np.testing.assert_array_equal(untested.weights, entry.iterations[2].weights)
    assert not untested.standard_deviations.any()
    entry.add(recording(entry.served.weights, 0.5e-3), told(update=False))
    tested = entry.feedforward()
    assert tested.provenance["tested"] is True
    told_so = measured(0.5e-3)["com.z"].plain()
    assert tested.provenance["errors"] == {"com.z": {**told_so, "unit": "m"}}


def test_an_untested_iteration_has_an_infinite_error() -> None:
    assert Iteration(3, NOTHING).error == np.inf


def test_key_rounds_and_sorts_its_parameters() -> None:
    def key(amplitude: float, frequency: float, **changes: Any) -> EntryKey:
        parameters = {"frequency": frequency, "amplitude": amplitude}
        return replace(EntryKey.of("r", "squat", "1", ("com.z",), parameters), **changes)

    one = key(0.03 + 4e-7, 0.25)
    assert one == key(0.03, 0.25 - 4e-7)
    assert one != key(0.030002, 0.25)
    for changes in (
        {"axes": ("com.x",)},
        {"robot": "other"},
        {"motion": "sway"},
        {"version": "2"},
        {"context": CONTEXT},
    ):
        assert one != replace(one, **changes)  # type: ignore[arg-type]
    assert one.describe() == "squat amplitude=0.03 frequency=0.25 on r"


def test_a_larger_error_at_lower_gains_is_not_taken_for_worse_weights() -> None:
    entry = entry_after(15e-3, 0.5e-3, 0.1e-3)
    lower = replace(MADE, gains={"P": [12.5], "D": [14.0]})
    entry.add(recording(entry.served.weights, 0.4e-3, circumstances=lower))
    assert entry.learning_gain == 1.0


def test_repeating_the_baseline_does_not_halve_the_gain() -> None:
    entry = entry_after(2e-3, 1e-3)
    entry.add(recording(NOTHING, 2e-3), told(update=False))
    assert entry.learning_gain == 1.0


# what repetitions tell about contraction


WAVE = np.sin(PHASE)[None, :]


def stable_recording(
    applied: np.ndarray = NOTHING, error: float = 1e-3, **changes: Any
) -> Recording:
    """A repetition whose position error is a sine with this RMS value."""
    position_error = np.sqrt(2) * error * WAVE
    lap = Lap(PHASE, 50 * position_error, position_error, 0.03 * WAVE)
    return recording(applied, error, laps=[lap] * 2, **changes)


def stable_entry(*errors: float) -> Entry:
    entry = empty_entry()
    for error in errors:
        applied = entry.served.weights if entry.iterations else NOTHING
        entry.add(stable_recording(applied, error), told("stable"))
    return entry


def learned_from(entry: Entry) -> list[int | None]:
    return [iteration.learned_from for iteration in entry.iterations]


def test_each_iteration_knows_what_it_was_learned_from() -> None:
    entry = stable_entry(4e-3, 2e-3, 3e-3, 2e-3)  # 2 is worse, 3 is learned from 1
    assert learned_from(entry) == [None, 0, 1, 1]
    entry.add(stable_recording(np.full((1, BASIS.L), 0.3), 1e-3), told("stable"))
    assert learned_from(entry)[-2:] == [None, 4]


def test_observed_is_the_share_of_the_one_it_was_learned_from() -> None:
    entry = stable_entry(4e-3, 2e-3, 3e-3, 2e-3, 0.5e-3)
    observed = entry.observed_contractions()
    assert observed is not None
    np.testing.assert_allclose(observed[:, 1], [0.5, 1.5, 0.25], rtol=1e-6)
    assert np.isnan(observed[:, 3:]).all()  # nothing there to be left over
    assert entry.contractions[0].observed[1] == pytest.approx(0.25)
    assert entry.contractions[0].observed[3] is None


def test_observed_does_not_need_position_errors() -> None:
    entry = empty_entry()
    entry.add(recording(error=4e-3, feedback=0.5))
    entry.add(recording(entry.served.weights, 2e-3, 0.1))
    observed = entry.observed_contractions()
    assert observed is not None
    assert observed[0, 0] == pytest.approx(0.2)
    assert entry.contractions == ()
    assert entry.filters() == ()


def test_tests_at_other_gains_are_not_compared() -> None:
    entry = stable_entry(4e-3)
    softer = replace(MADE, gains={"P": [25.0], "D": [10.0]})
    entry.add(stable_recording(entry.served.weights, 2e-3, circumstances=softer), told("stable"))
    assert entry.observed_contractions() is None
    assert entry.contractions[0].observed == (None,) * 13


def test_nothing_is_known_of_an_empty_entry() -> None:
    assert (empty_entry().filters(), empty_entry().contractions) == ((), ())
    assert empty_entry().observed_contractions() is None


def test_the_account_names_each_axis() -> None:
    key = EntryKey.of("r", "squat", "1", ("com.x", "com.z"), dict(KEY.parameters))
    both = replace(MADE, gains={"P": [50.0, 20.0], "D": [14.0, 9.0]})
    entry, twice = Entry(key, BASIS, both), np.vstack([WAVE, WAVE])
    laps = [Lap(PHASE, twice, twice / 100, twice / 20)]
    errors = {axis: AxisError(1e-3) for axis in key.axes}
    made = recording(np.zeros((2, BASIS.L)), laps=laps, circumstances=both, key=key, errors=errors)
    entry.add(made, told("stable"))
    assert [account.axis for account in entry.contractions] == ["com.x", "com.z"]
    stiff, soft = entry.contractions
    assert stiff.plain[1] < soft.plain[1]


def test_stiff_axes_count_as_the_feedback_counts_them() -> None:
    made_so = Circumstances({"P": [100.0, 25.0], "D": [20.0, 10.0]})
    errors = {"com.z": AxisError(1e-3), "torso.rz": AxisError(4e-3)}
    both = Iteration(1, np.zeros((2, 3)), errors=errors, circumstances=made_so)
    assert both.error == pytest.approx(0.1)
    unknown = Iteration(1, np.zeros((2, 3)), errors=errors)
    assert unknown.error == pytest.approx(np.sqrt((1e-6 + 16e-6) / 2))


def test_plain_learning_is_accounted_for_as_well() -> None:
    entry = empty_entry()
    entry.add(stable_recording(), told("plain"))
    assert len(entry.contractions) == 1


def test_the_stable_rule_never_goes_on_from_what_proved_worse() -> None:
    entry = stable_entry(4e-3, 2e-3, 3e-3)
    assert (entry.served.number, entry.learning_gain) == (1, 0.5)
    entry.add(stable_recording(entry.served.weights, 2e-3), told("stable"))
    assert entry.learning_gain == 0.5  # the best again is no success
    entry.add(stable_recording(entry.served.weights, 1e-3), told("stable"))
    assert entry.learning_gain == 1.0


def test_noise_at_the_floor_does_not_slow_learning_down_for_ever() -> None:
    entry = stable_entry(1e-3, 1.001e-3, 1e-3, 0.999e-3)
    assert entry.learning_gain == 1.0
    guarded = entry_after(1e-3, 1.001e-3, 1e-3, 0.999e-3)
    assert guarded.learning_gain == 0.5  # its sum would overshoot again


def test_a_test_without_positions_forgets_those_of_before() -> None:
    entry = stable_entry(4e-3)
    softer = replace(MADE, gains={"P": [25.0], "D": [10.0]})
    entry.add(recording(NOTHING, 3e-3, circumstances=softer))
    assert entry.iterations[0].error_weights is None
    assert entry.filters() == ()


def test_a_repeated_iteration_counts_once() -> None:
    once, twice = stable_entry(4e-3, 2e-3), stable_entry(4e-3, 2e-3)
    again = stable_recording(twice.iterations[1].weights, 2e-3)
    twice.add(again, told("stable", update=False))
    assert once.contractions == twice.contractions


def test_weights_say_how_uncertain_the_laps_leave_them() -> None:
    entry = empty_entry()
    laps = [Lap(PHASE, np.full((1, 100), feedback)) for feedback in (0.4, 0.6)]
    entry.add(recording(laps=laps))
    # of one lap 0.2 / sqrt(2), of two of them less by sqrt(2)
    assert entry.iterations[1].uncertainty == pytest.approx(0.1, rel=1e-6)
    assert entry.iterations[0].uncertainty is None
    np.testing.assert_allclose(entry.feedforward().standard_deviations, 0.1, rtol=1e-6)
