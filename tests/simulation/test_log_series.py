from __future__ import annotations

from pathlib import Path

import pytest

from tsd_casadi.controller.controller import Controller
from tsd_casadi.motions.squat import Squat
from tsd_clients.logs.log_series import LogSeries
from tsd_clients.logs.read_log import read_log
from tsd_clients.simulator.simulator import MujocoSimulator


@pytest.mark.parametrize("ending", ["npz", "mcap"])
def test_every_repetition_has_a_file(
    simulator: MujocoSimulator, controller: Controller, tmp_path: Path, ending: str
) -> None:
    logs = LogSeries(tmp_path / f"squat.{ending}")
    for number, amplitude in enumerate((0.01, 0.02)):
        run = simulator.run(controller, Squat(amplitude, 1.0), laps=2, observers=[logs])
        logs.conclude(run)
        log = read_log(tmp_path / f"squat-{number}.{ending}")
        assert log.ticks == run.ticks and log.outline is not None
        assert log.outline.parameters["amplitude"] == amplitude
    assert len(list(tmp_path.iterdir())) == 2
