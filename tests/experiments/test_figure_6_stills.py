from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib import pyplot as plt
from PIL import Image, ImageSequence

from tsd_casadi import Robot
from tsd_clients.film import gl_library
from tsd_clients.film.gl_library import HINT
from tsd_experiments.harness.experiment import Experiment
from tsd_experiments.harness.job import Result
from tsd_experiments.paper.figure_6_stills import HEIGHT, JOB, RATE, STILLS, WIDTH, Stills, movie


@pytest.fixture(scope="module")
def done(finish_experiment: Callable[[Experiment], dict[str, Result]]) -> dict[str, Result]:
    return finish_experiment(Stills(quick=True))


def paint(robot: Robot, postures: np.ndarray, width: int, height: int) -> np.ndarray:
    """Pictures whose brightness is the height of the centre of mass."""
    heights = np.array([robot.center_of_mass(q)[2] for q in postures])
    shades = 255 * (heights - heights.min()) / np.ptp(heights)
    return np.tile(shades[:, None, None, None], (1, height, width, 3)).astype(np.uint8)


def test_one_lap_is_kept(
    robot: Robot, done: dict[str, Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tsd_experiments.paper.figure_6_stills.render_postures", paint)
    arrays = done[JOB].arrays
    assert len(arrays["q"]) == RATE  # one lap of one second
    assert arrays["time"] == pytest.approx(np.arange(RATE) / RATE)
    com = [robot.center_of_mass(q)[2] - robot.home_com[2] for q in arrays["q"]]
    # MuJoCo's own centre of mass
    assert com == pytest.approx(arrays["com_z"], abs=1e-5)
    assert np.ptp(com) == pytest.approx(0.06, rel=0.03)
    assert f"{1e3 * np.ptp(com):.1f} mm" in Stills(quick=True).report(done).found[0]


def test_stills_and_movie(
    robot: Robot, done: dict[str, Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    module = "tsd_experiments.paper.figure_6_stills.render_postures"
    monkeypatch.setattr(module, paint)
    (figure,) = Stills(quick=True).report(done).figures
    drawn = figure.draw()
    assert len(drawn.axes) == STILLS
    # it begins in the middle, on its way down
    shades = [axes.images[0].get_array().mean() for axes in drawn.axes]
    assert np.argmin(shades) == 2
    assert np.argmax(shades) == 6
    plt.close(drawn)
    gif = movie(done, robot)
    assert gif is not None
    with Image.open(io.BytesIO(gif)) as film:
        assert film.size == (WIDTH, HEIGHT)
        # pictures that look the same are one that lasts longer
        durations = [frame.info["duration"] for frame in ImageSequence.Iterator(film)]
        assert sum(durations) == 1000
        assert min(durations) == 1000 // RATE
        film.seek(0)
        assert film.info["loop"] == 0


def test_without_a_library_there_is_a_hint(
    robot: Robot, done: dict[str, Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gl_library, "LIBRARIES", ())
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    section = Stills(quick=True).report(done)
    assert HINT in section.found
    assert section.figures == []
    assert movie(done, robot) is None


def test_nothing_to_show(robot: Robot) -> None:
    assert movie({}, robot) is None
