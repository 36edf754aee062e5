from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.abuse import outcomes
from benchmarks.abusive_records import KINDS
from tsd_casadi.database.database import Database
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.bound import LARGEST_ACCELERATION
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.plausible import (
    LARGEST_ERROR,
    LARGEST_GAIN,
    MOST_FUNCTIONS,
    MOST_NUMBERS,
    check_phase,
    check_plausible,
    check_size,
)
from tsd_casadi.learning.recording import Recording
from tsd_casadi.motions.squat import Squat
from tsd_casadi.state import Vector

BASIS = PeriodicBasis()
AXES = ("com.x", "com.z", "torso.rz")
FREQUENCY, P, D = 0.5, 50.0, 14.0
COUNT = 250
PHASE = np.linspace(0, 2 * np.pi, COUNT, endpoint=False)


def lap(phase: Vector = PHASE, size: float = 1.0) -> Lap:
    """What P and D feed back of an offset and a wave."""
    offset, wave = np.array([[0.0], [0.015], [0.002]]), np.array([[1e-3], [2e-3], [0.01]])
    error = size * (offset + wave * np.sin(phase))
    rate = size * 2 * np.pi * FREQUENCY * wave * np.cos(phase)
    return Lap(phase, P * error + D * rate, error, 0.03 * np.tile(np.sin(phase), (3, 1)))


def honest() -> Recording:
    parameters = {"amplitude": 0.03, "frequency": FREQUENCY, "height": 0.0}
    return Recording(
        key=EntryKey.of("r", "squat", Squat.version, AXES, parameters, Context("00", "ff")),
        basis=BASIS,
        applied=np.zeros((3, BASIS.L)),
        laps=[lap(PHASE + 2 * np.pi * number) for number in range(3)],
        errors={axis: AxisError(0.015) for axis in AXES},
        circumstances=Circumstances({"P": [P] * 3, "D": [D] * 3}, {}, "test", [30.0, 40.0, 200.0]),
        declaration=Squat.declaration(),
    )


def test_what_a_robot_did_is_taken() -> None:
    check_plausible(honest())


def moved(change: Callable[[Vector], Vector]) -> Callable[[Recording], Recording]:
    return lambda made: replace(
        made, laps=[replace(each, phase=change(each.phase)) for each in made.laps]
    )


def one_lap(**changes: object) -> Callable[[Recording], Recording]:
    def change(made: Recording) -> Recording:
        spoilt = {
            name: value(getattr(made.laps[1], name)) if callable(value) else value
            for name, value in changes.items()
        }
        return replace(made, laps=[made.laps[0], replace(made.laps[1], **spoilt), made.laps[2]])

    return change


def with_gains(**gains: list[float]) -> Callable[[Recording], Recording]:
    return lambda made: replace(made, circumstances=Circumstances({"P": [P] * 3, **gains}))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (moved(lambda phase: 0.6 * (phase - phase[0]) / 6.3), "0.596 rad, expected one whole lap"),
        (moved(lambda phase: 2 * (phase - phase[0])), "12.52 rad, expected one whole lap"),
        (moved(lambda phase: phase[::-1]), "phases that advance"),
        (moved(lambda phase: np.zeros(COUNT)), "phases that advance"),
        (moved(np.degrees), "radians, not degrees"),
        (moved(lambda phase: np.degrees(phase - phase[0])), "radians, not degrees"),
        (moved(lambda phase: np.where(phase % 6.28 < 1, phase, phase + 0.3)), "without a sample"),
        (one_lap(feedback=lambda values: -values), "lap 1 is .* RMS away from that of the others"),
        (one_lap(error=lambda values: -values), "what P and D make of the errors"),
        (one_lap(feedback=lambda values: 20 * values), "at most 9.81 m/s"),
        (one_lap(error=lambda values: 40 * values), "at most 0.5 m"),
        (with_gains(P=[-1.0, P, P]), "P is -1"),
        (with_gains(D=[D, D, 1e4]), "D is 10000"),
        (lambda made: replace(made, applied=made.applied + 10), "applied feedforward of com.x"),
        (lambda made: replace(made, errors=dict.fromkeys(AXES, AxisError(2.0))), "RMS error"),
        (
            lambda made: replace(made, circumstances=replace(made.circumstances, allowed=[1.0])),
            "allowed accelerations is 1",
        ),
        (
            lambda made: replace(
                made, circumstances=replace(made.circumstances, allowed=[1.0, 0.0, 1.0])
            ),
            "allowed acceleration of com.z is 0",
        ),
        (
            lambda made: replace(
                made, circumstances=replace(made.circumstances, allowed=[1.0, np.inf, 1.0])
            ),
            "allowed acceleration of com.z is inf",
        ),
        (
            lambda made: replace(
                made, laps=[Lap(each.phase[:1], each.feedback[:, :1]) for each in made.laps]
            ),
            "phase of lap 0 is of shape \\(1,\\)",
        ),
        (
            lambda made: replace(
                made, laps=[Lap(each.phase[:0], each.feedback[:, :0]) for each in made.laps]
            ),
            "phase of lap 0 is of shape",
        ),
    ],
)
def test_what_no_robot_did_is_refused_with_the_reason_and_nothing_is_stored(
    change: Callable[[Recording], Recording], said: str, tmp_path: Path
) -> None:
    with Database(tmp_path / "d.sqlite") as database:
        with pytest.raises(InvalidValue, match=said):
            database.record(change(honest()))
        assert database.entries() == []


def wrong_sign(made: Recording) -> Recording:
    return replace(made, laps=[replace(each, feedback=-each.feedback) for each in made.laps])


@pytest.mark.parametrize(
    "gains", [{"P": [P, P, 0.0], "D": [D] * 3}, {"P": [P] * 3, "D": [0.0, D, D]}]
)
def test_an_axis_without_stiffness_hides_no_wrong_sign_beside_it(
    gains: dict[str, list[float]],
) -> None:
    made = replace(honest(), circumstances=Circumstances(gains))
    P_, D_ = (np.array(gains[name])[:, None] for name in ("P", "D"))
    rate = 2 * np.pi * FREQUENCY * np.array([[1e-3], [2e-3], [0.01]]) * np.cos(PHASE)
    made = replace(
        made,
        laps=[replace(each, feedback=P_ * each.error + D_ * rate) for each in made.laps],
    )
    check_plausible(made)
    with pytest.raises(InvalidValue, match="what P and D make of the errors"):
        check_plausible(wrong_sign(made))


def test_a_parameter_that_was_left_out_hides_no_wrong_sign(tmp_path: Path) -> None:
    made = honest()
    left_out = tuple(each for each in made.key.parameters if each[0] != "frequency")
    made = replace(made, key=replace(made.key, parameters=left_out))
    with Database(tmp_path / "d.sqlite") as database:
        with pytest.raises(InvalidValue, match="what P and D make of the errors"):
            database.record(wrong_sign(made))
        assert database.entries() == []
        database.record(made)


@given(st.floats(0, 100), st.integers(26, 400), st.booleans())
def test_any_whole_lap_is_taken_wherever_it_starts(
    start: float, count: int, is_wrapped: bool
) -> None:
    phase = start + np.linspace(0, 2 * np.pi, count, endpoint=False)
    check_phase(phase % (2 * np.pi) if is_wrapped else phase, BASIS, "lap")


@given(st.integers(0, 10_000))
def test_any_gap_wider_than_the_functions_are_apart_is_found(seed: int) -> None:
    rng = np.random.default_rng(seed)
    width = rng.uniform(1.1, 10) * 2 * np.pi / BASIS.L
    start = rng.uniform(0, 2 * np.pi - width)
    left = PHASE[(start > PHASE) | (start + width + 2 * np.pi / COUNT < PHASE)]
    with pytest.raises(InvalidValue, match=r"without a sample|one whole lap"):
        check_phase(left, BASIS, "lap")


def test_bounds_hold_at_their_edge() -> None:
    made = honest()
    largest = LARGEST_ACCELERATION["m"]
    applied = np.zeros((3, BASIS.L))
    applied[0] = largest
    check_plausible(replace(made, applied=applied))
    with pytest.raises(InvalidValue, match="applied"):
        check_plausible(replace(made, applied=applied * (1 + 1e-9)))
    errors = dict.fromkeys(AXES, AxisError(LARGEST_ERROR["m"]))
    check_plausible(replace(made, errors=errors))
    gains = {name: [value] * 3 for name, value in LARGEST_GAIN.items()}
    bare = [Lap(each.phase, each.feedback) for each in made.laps]
    check_plausible(replace(made, circumstances=Circumstances(gains), laps=bare))


def test_what_would_keep_a_learner_busy_is_refused_before_it_is_fitted() -> None:
    check_size([Lap(np.empty(MOST_NUMBERS // BASIS.L), np.empty((1, 1)))], BASIS)
    with pytest.raises(InvalidValue, match="fewer laps"):
        check_size([Lap(np.empty(MOST_NUMBERS // BASIS.L + 1), np.empty((1, 1)))], BASIS)
    few = [Lap(np.empty(1_000), np.empty((1, 1_000)))]
    check_size(few, PeriodicBasis.of_size(MOST_FUNCTIONS))
    with pytest.raises(InvalidValue, match="at most 200 basis functions"):
        check_size(few, PeriodicBasis.of_size(MOST_FUNCTIONS + 1))


def test_noise_where_next_to_nothing_is_to_be_learned_is_no_disagreement() -> None:
    rng = np.random.default_rng(0)
    noisy = [
        Lap(PHASE, each.feedback * 1e-3 + rng.normal(0, 0.3, (3, COUNT))) for each in honest().laps
    ]
    check_plausible(replace(honest(), laps=noisy))


def test_abusive_records_are_refused_or_what_is_served_is_bounded(tmp_path: Path) -> None:
    found = list(outcomes(honest(), 5 * len(KINDS), Random(1).randrange(1000), tmp_path))
    assert all(each.is_within for each in found)
    # each kind is refused at least once: none of them goes unseen
    assert {each.kind for each in found if each.refusal} == set(KINDS)
