from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi.controller.controller import Controller
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.repetition.tick_row import TickRow
from tsd_casadi.state import Vector
from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_clients.telemetry.outline import outline_of


class Rows:
    """Every tick as a row."""

    def start(self, setting: Setting) -> None:
        self.row, self.rows, self.outline = TickRow(setting), list[Vector](), outline_of(setting)

    def tick(self, moment: Moment) -> None:
        self.rows.append(self.row.of(moment))

    def missed(self, moment: Moment) -> None:
        self.rows.append(self.row.of(moment))

    def lap(self, lap: Lap) -> None:
        pass

    def end(self, outcome: str) -> None:
        pass


def test_rows_read_by_what_the_run_says_of_itself_are_its_log(
    simulator: MujocoSimulator, controller: Controller
) -> None:
    kept = Rows()
    run = simulator.run(controller, Squat(0.02, 1.0), laps=2, observers=[kept])
    # as after a way through a file
    outline = RunOutline.decode(kept.outline.encode())
    layout, rows = outline.layout, np.array(kept.rows)
    assert layout == kept.row.layout
    assert rows.shape == (run.ticks, layout.size)
    for name in ("time", "phase", "lap", "missed", "tick_us"):
        assert np.array_equal(rows[:, layout.slice(name)][:, 0], run.log[name]), name
    for name in ("reference", "true_error", "feedforward"):
        assert np.array_equal(rows[:, layout.slice(name)], run.log[name]), name
    reply = rows[:, layout.slice("reply")][:, outline.known.reply.slice("error")]
    assert np.array_equal(reply.astype(np.float32), run.log["all_errors"])
    q = rows[:, layout.slice("true_q")]
    assert q == pytest.approx(run.log["q"], abs=1e-6)
    assert outline.axes == run.axes
    assert outline.model == run.model
