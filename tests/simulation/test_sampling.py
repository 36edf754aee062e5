from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from tsd_casadi.controller.controller import Controller
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.state import Vector
from tsd_casadi.tick.missed import Cause, Missed
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_clients.telemetry import sampling
from tsd_clients.telemetry.sampling import Sampling

TICK = 0.0004  # s by the clock


class Sampled:
    """What is seen of a repetition whose ticks take 0.4 ms each by the clock."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.now = 0.0
        self.times: list[float] = []
        self.rows: list[Vector] = []
        patch.setattr(sampling, "perf_counter", lambda: self.now)

    def start(self, setting: Setting) -> None:
        self.sampling = Sampling(setting)

    def tick(self, moment: Moment) -> None:
        self.now += TICK
        self.times.append(moment.tick_time)
        # as if every third tick had no answer
        moment.missed = None if len(self.times) % 3 else Missed(Cause.LATE)
        row = self.sampling.take(moment)
        if row is not None:
            self.rows.append(row)

    def missed(self, moment: Moment) -> None:
        self.tick(moment)

    def lap(self, lap: Lap) -> None:
        pass

    def end(self, outcome: str) -> None:
        pass


def test_one_tick_in_ten_milliseconds_is_seen_and_all_are_counted(
    simulator: MujocoSimulator, controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = Sampled(monkeypatch)
    run = simulator.run(controller, Squat(0.02, 1.0), laps=2, observers=[seen])
    layout, rows = seen.sampling.layout, np.array(seen.rows)

    def column(name: str) -> Vector:
        return cast("Vector", rows[:, layout.slice(name)][:, 0])

    ticks = column("ticks").astype(int)
    ends = np.cumsum(ticks)
    assert len(rows) == pytest.approx(run.ticks * TICK / sampling.SPACING, rel=0.05)
    assert set(ticks[1:]) <= {25, 26}
    assert run.ticks - ends[-1] < 26
    np.testing.assert_array_equal(column("time"), run.log["time"][ends - 1])
    for end, count, median, largest in zip(
        ends, ticks, column("tick_us_median"), column("tick_us_largest"), strict=True
    ):
        between = seen.times[end - count : end]
        assert largest == max(between)
        assert min(between) <= median <= max(between)
        assert sum(each <= median for each in between) >= len(between) / 2
    # of the first n ticks n // 3
    missed = np.diff(ends // 3, prepend=0)
    np.testing.assert_array_equal(column("missed_since"), missed)
