"""Films by the command line's actions, from a run and from its log."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

from tsd_casadi import Controller, Robot
from tsd_casadi.exceptions import NotAvailable
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.run import Run
from tsd_cli.actions.film import Footage, film_log, title_of
from tsd_cli.options.film import FilmOptions, FilmSizeOptions
from tsd_clients import MujocoSimulator
from tsd_clients.film.video_file import GIF_RATE
from tsd_clients.logs.log_file import save_log

SIZE = "240x180"


@pytest.fixture(scope="module")
def run(simulator: MujocoSimulator, controller: Controller) -> Run:
    return simulator.run(controller, Squat(0.03, 1.0), laps=2)


def _seconds(path: Path) -> float:
    with Image.open(path) as film:
        assert film.size == (240, 180)
        total = 0.0
        for place in range(film.n_frames):
            film.seek(place)
            total += film.info["duration"] / 1e3
        return total


def test_a_film_of_several_runs_has_the_last_lap_of_each(
    robot: Robot, run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "learning.gif"
    footage = Footage(FilmOptions(video=path, video_size=SIZE), robot)
    for _ in range(2):
        footage.keep_last_lap(run)
    try:
        footage.make()
    except NotAvailable as error:
        pytest.skip(str(error))
    assert _seconds(path) == pytest.approx(2.0, abs=2 / GIF_RATE)
    assert f"film of 2.0 s: {path}" in capsys.readouterr().err


def test_a_film_of_a_log_has_all_of_it(robot: Robot, run: Run, tmp_path: Path) -> None:
    log, path = tmp_path / "run.npz", tmp_path / "run.gif"
    short = {name: values[:1500] for name, values in run.log.items()}
    save_log(replace(run, log=short), log)
    try:
        film_log(log, path, None, FilmSizeOptions(video_size=SIZE))
    except NotAvailable as error:
        pytest.skip(str(error))
    assert _seconds(path) == pytest.approx(1.5, abs=1 / GIF_RATE)


def test_without_a_film_nothing_is_kept(robot: Robot, run: Run) -> None:
    footage = Footage(FilmOptions(), robot)
    footage.keep(run)
    footage.make()


def test_a_title_says_what_is_special(run: Run) -> None:
    assert title_of(run) == "hermes_lower: squat 3 cm, model error 10 %"
    softer = replace(run, settings={**run.settings, "p_scale": 0.2, "model_error": 0.0})
    assert title_of(softer) == "hermes_lower: squat 3 cm, P x 0.2"
