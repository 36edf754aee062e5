"""'tsd log' on files that other tests write, too."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tsd_casadi import Feedforward, PeriodicBasis, Run, Squat
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_cli import command_line
from tsd_clients.logs.log_file import save_log

SIZES = {"(k,)": 2, "(a,)": 3, "(7 + n,)": 9, "(6 + n,)": 8, "(n,)": 2, "(6 c,)": 12}


@pytest.fixture
def run() -> Run:
    """Ten ticks of a hold and of two laps, the second one measured."""
    rng, ticks = np.random.default_rng(0), 10
    log = {
        name: (
            rng.normal(size=(ticks, SIZES[field.shape]) if field.shape != "()" else ticks)
        ).astype(field.type)
        for name, field in LOG_FIELDS.items()
    }
    log["time"] = 1e-3 * np.arange(ticks)
    log["lap"] = np.array([-1, -1, 0, 0, 0, 0, 1, 1, 1, 1])
    log["measured"] = log["lap"] == 1
    log["status"], log["missed"] = np.zeros((2, ticks), dtype=int)
    log["joint_limits"][:] = 0
    log["joint_limits"][3:5, 1] = -4
    return Run(
        robot="hermes_lower",
        motion=Squat(0.03, 0.25),
        axes=("com.z", "torso.ry"),
        feedforward=Feedforward.zero(("com.z",), PeriodicBasis()),
        gains={"P": [1.0], "D": [1.0]},
        settings={},
        log=log,
        laps=[],
        laps_run=2,
        steady=True,
        fell=False,
        vetoes=[],
        failures={},
        model="0123",
    )


def call(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    with pytest.raises(SystemExit) as caught:
        command_line.run(["log", *map(str, arguments)])
    captured = capsys.readouterr()
    assert caught.value.code == 0, captured.err
    return captured.out


@pytest.mark.parametrize("ending", ["npz", "csv"])
def test_measures_shown_are_those_of_the_run(
    run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str], ending: str
) -> None:
    path = tmp_path / f"run.{ending}"
    save_log(run, path)
    found = json.loads(call(capsys, "show", path, "--json", "-"))
    for name, value in vars(run.errors["com.z"]).items():
        assert found["errors"]["com.z"][name] == value, name
    assert found["errors"]["torso.ry"]["unit"] == "rad"
    assert (found["ticks"], found["laps_run"], found["laps_measured"]) == (10, 2, 1)
    assert list(found["at_limits"].values()) == [2]
    shown = call(capsys, "show", path)
    assert "10 ticks from 0.000 s to 0.009 s" in shown and "com.z" in shown
