from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.repetition.tick_log import COLUMNS, TickLog

TICKS = 40


def add_ticks(log: TickLog, feedback: float, count: int = TICKS) -> None:
    """A lap whose feedback is constant."""
    for _ in range(count):
        row = dict.fromkeys(COLUMNS, 0.0)
        row.update(time=float(len(log)), feedback=feedback, error=feedback / 50, reference=0.1)
        log.add(*row.values())


def log_of(*levels: float) -> TickLog:
    """Ticks of a hold, then whole laps."""
    log = TickLog()
    add_ticks(log, 9.0, count=10)
    for level in levels:
        start = len(log)
        add_ticks(log, level)
        log.add_lap(start)
    return log


def test_a_lap_has_what_learning_needs() -> None:
    (lap,) = log_of(0.5).laps
    np.testing.assert_array_equal(lap.feedback, np.full((1, TICKS), 0.5))
    np.testing.assert_array_equal(lap.error, np.full((1, TICKS), 0.01))
    np.testing.assert_array_equal(lap.reference, np.full((1, TICKS), 0.1))
    assert lap.phase.shape == (TICKS,)


@pytest.mark.parametrize(
    ("levels", "first"),
    [
        ((1.0, 0.5, 0.5, 0.5), 1),  # steady from the second on
        ((0.5, 0.5), 0),
        ((1.0, 2.0, 3.0), 1),  # never steady: the last two
    ],
)
def test_steady_laps_are_measured_else_the_last_two(levels: tuple[float, ...], first: int) -> None:
    log = log_of(*levels)
    start, laps = log.measured_laps()
    assert start == 10 + first * TICKS
    assert len(laps) == len(levels) - first
    assert laps[-1] is log.laps[-1]


@pytest.mark.parametrize("levels", [(), (1.0,)])
def test_less_than_two_laps_are_not_measured(levels: tuple[float, ...]) -> None:
    log = log_of(*levels)
    assert log.measured_laps() == (len(log), [])


def test_arrays_have_every_field_in_its_type() -> None:
    log = log_of(1.0)
    arrays = log.arrays(measured_from=len(log) - 3)
    assert list(arrays) == list(LOG_FIELDS)
    for name, values in arrays.items():
        assert values.dtype == LOG_FIELDS[name].type
        assert len(values) == len(log) == 10 + TICKS
    assert arrays["measured"].sum() == 3
    np.testing.assert_array_equal(arrays["time"], np.arange(len(log)))
