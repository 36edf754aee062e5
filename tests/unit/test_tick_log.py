from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.repetition.tick_log import COLUMNS, TickLog

TICKS = 40
HOLD = 10
INDEX = np.array([2, 0])  # of two axes in the errors of three


def add_ticks(log: TickLog, level: float, lap: int, count: int = TICKS) -> None:
    """Ticks whose errors are level, 10 level and 100 level."""
    for _ in range(count):
        state: Any = SimpleNamespace(q=np.full(7, level), v=np.zeros(6))
        tick = SimpleNamespace(
            error=level * np.array([1.0, 10.0, 100.0]),
            feedback=-level * np.array([1.0, 10.0, 100.0]),
            reply=np.array([1.0, 2.0, 3.0, 4.0, 0, 0, 0, 0, 0.0, -4.0]),
            compute_time=5.0,
        )
        moment: Any = SimpleNamespace(
            time=float(log.ticks),
            phase=0.1 * log.ticks,
            lap=lap,
            reference=SimpleNamespace(x=np.array([level, 0.0])),
            true_error=np.full(2, np.nan),
            feedforward=np.zeros(2),
            state=state,
            truth=None,
            tick=tick,
            tau=np.zeros(3),
            tick_time=6.0,
        )
        log.tick(moment)


def log_of(*levels: float) -> TickLog:
    """Ticks of a hold, then whole laps."""
    log = TickLog()
    reply = SimpleNamespace(size=4, slice=lambda name: slice(2, 4))
    controller = SimpleNamespace(format=SimpleNamespace(reply=reply, joints=("hip", "knee")))
    setting: Any = SimpleNamespace(index=INDEX, controller=controller)
    log.start(setting)
    add_ticks(log, 9.0, -1, count=HOLD)
    for number, level in enumerate(levels):
        add_ticks(log, level, number)
        log.lap(None)  # type: ignore[arg-type]
    log.end("steady")
    return log


def test_columns_are_those_of_the_axes_in_their_order() -> None:
    rows = log_of(0.5).columns(HOLD, ["error", "feedback", "reference", "wrenches"])
    assert list(rows) == ["error", "feedback", "reference", "wrenches"]
    np.testing.assert_array_equal(rows["error"], np.tile([50.0, 0.5], (TICKS, 1)))
    np.testing.assert_array_equal(rows["feedback"], -rows["error"])
    np.testing.assert_array_equal(rows["reference"], np.tile([0.5, 0.0], (TICKS, 1)))
    np.testing.assert_array_equal(rows["wrenches"], np.tile([3.0, 4.0], (TICKS, 1)))


def test_what_bounds_the_joints_is_kept() -> None:
    rows = log_of(0.5).columns(HOLD, ["joint_limits"])
    np.testing.assert_array_equal(rows["joint_limits"], np.tile([0, -4], (TICKS, 1)))


@pytest.mark.parametrize("first", [0, 1, 2])
def test_measured_is_from_the_first_such_lap_to_the_end_of_the_last(first: int) -> None:
    log = log_of(1.0, 2.0, 3.0)
    add_ticks(log, 4.0, 3, count=7)  # of a lap that never ended
    measured = log.log(first)["measured"]
    expected = np.zeros(HOLD + 3 * TICKS + 7, dtype=bool)
    expected[HOLD + first * TICKS : HOLD + 3 * TICKS] = True
    np.testing.assert_array_equal(measured, expected)


@pytest.mark.parametrize("levels", [(), (1.0,)])
def test_nothing_is_measured_where_there_is_no_such_lap(levels: tuple[float, ...]) -> None:
    assert not log_of(*levels).log(None)["measured"].any()


def test_arrays_have_every_field_in_its_type() -> None:
    log = log_of(1.0)
    arrays = log.log(0)
    assert list(arrays) == list(LOG_FIELDS)
    assert [*COLUMNS, "measured"] == list(LOG_FIELDS)
    for name, values in arrays.items():
        assert values.dtype == LOG_FIELDS[name].type
        assert len(values) == log.ticks == HOLD + TICKS
    np.testing.assert_array_equal(arrays["time"], np.arange(log.ticks))


def test_the_truth_is_kept_where_it_is_known() -> None:
    log = log_of()
    known: Any = SimpleNamespace(state=SimpleNamespace(q=np.full(7, 3.0), v=np.zeros(6)))
    add = log.tick

    def with_truth(moment: Any) -> None:
        moment.truth = known
        add(moment)

    log.tick = with_truth  # type: ignore[method-assign]
    add_ticks(log, 1.0, 0, count=1)
    np.testing.assert_array_equal(log.log(None)["q"][-1], 3.0)
    np.testing.assert_array_equal(log.log(None)["q"][0], 9.0)
