"""What each learning rule answers; what an entry makes of it is told in test_entry."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import numpy as np
import pytest

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.iteration import FittedRepetition, Iteration
from tsd_casadi.learning.iterative_learning import update_stably
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import RULES, find_rule
from tsd_casadi.learning.rules.guarded import Guarded
from tsd_casadi.learning.rules.plain import Plain
from tsd_casadi.learning.rules.rule import Rule, RuleName
from tsd_casadi.learning.rules.stable import Stable

BASIS = PeriodicBasis()
PHASE = np.linspace(0, 2 * np.pi, 100, endpoint=False)
WAVE = np.sin(PHASE)[None, :]
BARE, WHOLE = Lap(PHASE, WAVE), Lap(PHASE, WAVE, WAVE / 100, WAVE / 20)
GAINS: dict[str, Any] = {"P": [50.0], "D": [14.0]}
MADE = Circumstances(GAINS)
KEY = EntryKey.of("r", "squat", "1", ("com.z",), {"amplitude": 0.03, "frequency": 0.25})
JUMP = EntryKey.of("r", "jump", "1", ("com.z",), {"depth": 1.0})
FEEDBACK = np.full((1, BASIS.L), 0.4)

every_rule = pytest.mark.parametrize("rule", RULES.values(), ids=list(RULES))
careful = pytest.mark.parametrize("rule", [Guarded(), Stable()])


def recording(**changes: Any) -> Recording:
    made = Recording(
        key=KEY,
        basis=BASIS,
        applied=np.zeros((1, BASIS.L)),
        laps=[WHOLE],
        errors={"com.z": AxisError(1e-3)},
        circumstances=MADE,
    )
    return replace(made, **changes)


def iteration(number: int, error: float, level: float = 0.0) -> Iteration:
    """An iteration of equal weights whose repetition had this RMS error [m]."""
    position_error = BASIS.fit(PHASE, np.sqrt(2) * error * WAVE)
    return Iteration(
        number,
        np.full((1, BASIS.L), level),
        errors={"com.z": AxisError(error)},
        circumstances=MADE,
        feedback=FEEDBACK,
        error_weights=position_error,
        reference_weights=BASIS.fit(PHASE, 0.03 * WAVE),
    )


BEST, WORSE = iteration(1, 1e-3, 0.3), iteration(2, 2e-3, 0.7)
NEWEST = Iteration(3, np.ones((1, BASIS.L)))


# their words


def test_every_word_of_messages_and_database_is_a_rule() -> None:
    assert tuple(RULES) == get_args(RuleName)
    assert [find_rule(name).name for name in RULES] == list(RULES)


def test_an_unknown_rule_is_named_beside_those_that_exist() -> None:
    with pytest.raises(InvalidValue, match=r"rule is 'reckless', expected one of guarded, plain"):
        find_rule("reckless")


@every_rule
def test_a_rule_keeps_nothing(rule: Rule) -> None:
    assert rule == type(rule)()


# what is served


@every_rule
def test_what_is_untested_is_served_to_be_tested(rule: Rule) -> None:
    assert rule.served(NEWEST, BEST) is NEWEST


@careful
def test_after_a_worse_one_the_best_is_served(rule: Rule) -> None:
    assert rule.served(WORSE, BEST) is BEST


def test_the_plain_sum_serves_what_proved_worse() -> None:
    assert Plain().served(WORSE, BEST) is WORSE


# what is gone on from, and how far


@careful
def test_a_worse_one_is_not_learned_from(rule: Rule) -> None:
    assert not rule.goes_on_from(WORSE, BEST)
    assert rule.goes_on_from(BEST, BEST)
    assert rule.goes_on_from(iteration(4, 1e-3), BEST)  # as good is good enough


def test_the_plain_sum_goes_on_from_everything() -> None:
    assert Plain().goes_on_from(WORSE, BEST)


@pytest.mark.parametrize(
    ("rule", "after_better", "after_worse"),
    [(Plain(), 0.25, 0.25), (Guarded(), 0.25, 0.125), (Stable(), 0.5, 0.125)],
)
def test_the_learning_gain_after_a_better_and_a_worse_one(
    rule: Rule, after_better: float, after_worse: float
) -> None:
    assert rule.gain_after(0.25, True) == after_better
    assert rule.gain_after(0.25, False) == after_worse


@every_rule
def test_no_rule_learns_more_than_all_of_a_change(rule: Rule) -> None:
    assert rule.gain_after(1.0, True) == 1.0


# which weights come next


def test_the_plain_sum_takes_all_of_the_feedback_whatever_the_gain() -> None:
    weights = Plain().next_weights(KEY, BASIS, [BEST, WORSE], FEEDBACK, 0.25)
    np.testing.assert_array_equal(weights, WORSE.weights + FEEDBACK)


def test_the_guarded_sum_takes_a_share_of_the_feedback() -> None:
    weights = Guarded().next_weights(KEY, BASIS, [BEST, WORSE], FEEDBACK, 0.25)
    np.testing.assert_array_equal(weights, WORSE.weights + 0.25 * FEEDBACK)


def test_the_stable_rule_learns_from_all_tests_with_known_positions() -> None:
    unknown = replace(iteration(0, 3e-3), error_weights=None, reference_weights=None)
    found = Stable().next_weights(KEY, BASIS, [unknown, WORSE, BEST], FEEDBACK, 0.5)
    known = [test.repetition for test in (WORSE, BEST)]
    assert all(isinstance(each, FittedRepetition) for each in known)
    expected = update_stably(
        [each for each in known if each is not None], BASIS, 0.25, [50.0], [14.0], gain=0.5
    )
    np.testing.assert_array_equal(found, expected.weights)


def test_the_stable_rule_recomputes_the_feedback() -> None:
    one = Stable().next_weights(KEY, BASIS, [WORSE, BEST], FEEDBACK, 1.0)
    other = Stable().next_weights(KEY, BASIS, [WORSE, BEST], 7 * FEEDBACK, 1.0)
    np.testing.assert_array_equal(one, other)


# what they ask of a recording


@every_rule
def test_whole_laps_do_for_every_rule(rule: Rule) -> None:
    rule.check(recording())


@pytest.mark.parametrize("rule", [Plain(), Guarded()])
def test_the_sum_needs_neither_errors_nor_frequency_nor_gains(rule: Rule) -> None:
    rule.check(recording(laps=[BARE], key=JUMP, circumstances=replace(MADE, gains={})))


@pytest.mark.parametrize("laps", [[BARE], [WHOLE, BARE], [replace(WHOLE, reference=None)]])
def test_the_stable_rule_asks_for_errors_and_references(laps: list[Lap]) -> None:
    with pytest.raises(InvalidValue, match=r"laps.*error and reference.*or another rule"):
        Stable().check(recording(laps=laps))


@pytest.mark.parametrize("gains", [{}, {"P": [50.0]}, {"P": [0.0], "D": [14.0]}])
def test_the_stable_rule_asks_for_gains(gains: dict[str, list[float]]) -> None:
    with pytest.raises(InvalidValue, match=r"frequency, P and D.*com\.z a positive P"):
        Stable().check(recording(circumstances=replace(MADE, gains=gains)))


def test_the_stable_rule_asks_for_a_frequency() -> None:
    with pytest.raises(InvalidValue, match=r"None, \[50\.0\] and \[14\.0\]"):
        Stable().check(recording(key=JUMP))
