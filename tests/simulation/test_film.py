from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import Image

from tsd_casadi import Controller, Robot
from tsd_casadi.exceptions import InvalidValue, NotAvailable
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.standing import stand
from tsd_casadi.state import State
from tsd_clients.film import gl_library
from tsd_clients.film.arrow_overlay import COLOR, draw_arrows, project
from tsd_clients.film.clip import Clip, last_lap, make_clip
from tsd_clients.film.make_film import check_size, make_film
from tsd_clients.film.robot_frames import robot_frames
from tsd_clients.film.strip_charts import StripCharts
from tsd_clients.simulator.simulator import MujocoSimulator

SIZE = (240, 180)


@pytest.fixture(scope="module")
def run(simulator: MujocoSimulator, controller: Controller) -> Run:
    return MujocoSimulator(simulator.robot, 0.1).run(controller, Squat(0.03, 1.0), laps=2)


@pytest.fixture(scope="module")
def clip(robot: Robot, run: Run) -> Clip:
    """A lap in ten pictures."""
    return make_clip(robot, last_lap(run.log), run.axes, rate=10.0)


def test_a_clip_is_the_log_at_a_films_rate(robot: Robot, run: Run) -> None:
    clip = make_clip(robot, run.log, run.axes, rate=25.0, plotted=1)
    assert clip.seconds == pytest.approx(run.ticks * 1e-3, abs=1 / 25)
    assert np.diff(clip.time) == pytest.approx(1 / 25, abs=1.1e-3)
    assert clip.axes == run.axes[:1]
    tick = round(clip.time[7] * 1e3)
    assert clip.q[7] == pytest.approx(run.log["q"][tick], abs=1e-6)
    assert clip.signals["feedback"][7] == pytest.approx(run.log["feedback"][tick, :1])
    assert clip.rms == pytest.approx([run.errors[run.axes[0]].rms])


def test_a_ghost_is_where_mujoco_sees_the_reference(robot: Robot, run: Run) -> None:
    """MuJoCo's centre of mass of ghost and robot differ by the error along every axis."""
    clip = make_clip(robot, run.log, run.axes, rate=5.0)
    simulator = MujocoSimulator(robot)  # as the controller believes the robot
    data = mujoco.MjData(simulator.model)

    def center(q: np.ndarray) -> np.ndarray:
        simulator.state_map.write(data, State(q, np.zeros(robot.nv)))
        mujoco.mj_forward(simulator.model, data)
        return np.array(data.subtree_com[0])

    pairs = zip(clip.q, clip.ghosts, strict=True)
    seen = np.array([center(ghost) - center(q) for q, ghost in pairs])
    for axis, error in zip(clip.axes, clip.signals["error"].T, strict=True):
        # q of a log has 32 bits
        assert seen[:, "xyz".index(axis[-1])] == pytest.approx(error, abs=1e-6), axis
    assert np.abs(seen[:, 2]).max() > 5e-3


def test_a_log_of_another_robot_is_refused(mini_biped: Robot, run: Run) -> None:
    with pytest.raises(InvalidValue, match="not one of mini_biped"):
        make_clip(mini_biped, run.log, run.axes, rate=25.0)


def test_a_tick_without_an_answer_has_no_ghost_and_no_arrow(robot: Robot, run: Run) -> None:
    missed = {name: values[:1].copy() for name, values in run.log.items()}
    for name in ("all_errors", "wrenches", "error"):
        missed[name][:] = np.nan
    clip = make_clip(robot, missed, run.axes, rate=25.0)
    assert np.array_equal(clip.ghosts, clip.q)
    assert np.array_equal(clip.arrows[:, :, 0], clip.arrows[:, :, 1])
    assert np.isnan(clip.rms).all()
    StripCharts([clip], 200, 150)


def test_charts_grow_with_time(clip: Clip) -> None:
    charts = StripCharts([clip, clip], 240, 200)
    early, late, over = (charts.at(share * 2 * clip.seconds) for share in (0.25, 0.5, 1.0))
    changed = np.flatnonzero((early != over).any(axis=(0, 2)))
    # what is behind stays, what is ahead is empty
    assert changed.min() > 0.25 * 240
    assert np.array_equal(early[:, : changed.min()], late[:, : changed.min()])
    drawn = [int((picture < 250).any(axis=2).sum()) for picture in (early, late, over)]
    assert drawn[0] < drawn[1] < drawn[2]


@pytest.mark.parametrize("far", [1.0, 3.0])
def test_curves_are_where_their_values_are(clip: Clip, far: float) -> None:
    """One axis that jumps from 0 to some value leaves two lines of its colour in each chart."""
    step = np.where(np.arange(len(clip.time)) < len(clip.time) // 2, 0.0, far)[:, None]
    signals = dict.fromkeys(clip.signals, step)
    charts = StripCharts([replace(clip, axes=("com.z",), signals=signals)], 240, 300)
    picture = charts.at(clip.seconds).astype(int)
    is_line = (picture[:, :, 2] - picture[:, :, 0] > 60).sum(axis=1) > 30
    begins = np.flatnonzero(np.diff(is_line.astype(int)) == 1)
    # the higher value above, the same distance in every chart
    distances = np.diff(begins)[::2]
    assert len(begins) == 6
    assert np.ptp(distances) <= 8  # labels leave each chart a little more or less
    assert distances[0] > 30


@pytest.mark.parametrize("point", [(0.1, 0.1, 0.0), (-0.4, 0.3, 0.0), (0.5, -0.2, 0.0)])
def test_arrows_are_drawn_where_the_camera_sees_them(point: tuple[float, ...]) -> None:
    """Against MuJoCo's own selection of what is under a place in the picture."""
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><geom type="plane" size="5 5 1"/></worldbody></mujoco>'
    )
    data, option = mujoco.MjData(model), mujoco.MjvOption()
    mujoco.mj_forward(model, data)
    scene, camera = mujoco.MjvScene(model, 10), mujoco.MjvCamera()
    camera.distance, camera.azimuth, camera.elevation = 3.0, 130.0, -25.0
    everything = mujoco.mjtCatBit.mjCAT_ALL.value
    mujoco.mjv_updateScene(model, data, option, None, camera, everything, scene)
    x, y = project(scene, np.array(point), 400, 300) / (400, 300)
    found, geom, flex, skin = np.zeros(3), *np.zeros((3, 1, 1), dtype=np.int32)
    at = (400 / 300, x, 1 - y, scene, found, geom, flex, skin)
    mujoco.mjv_select(model, data, option, *at)
    assert found == pytest.approx(point, abs=1e-5)


def test_an_arrow_points_from_foot_to_tip() -> None:
    picture = np.full((400, 100, 3), 255, dtype=np.uint8)
    drawn = draw_arrows(picture, np.array([[[50.0, 150.0], [50.0, 50.0]]]))
    rows, columns = np.nonzero((drawn == COLOR).all(axis=2))
    assert (rows.min(), rows.max()) == (50, 150)
    widths = [np.ptp(columns[rows == row]) for row in (58, 100)]
    assert widths[0] > widths[1] > 0  # head and shaft
    assert np.array_equal(draw_arrows(picture, np.full((1, 2, 2), 50.0)), picture)


def test_the_robot_and_its_ghost_are_seen(robot: Robot) -> None:
    q = np.array([stand(robot, height).q for height in (0.0, 0.0, -0.08)])
    ghosts = q[[0, 2, 2]]
    nothing = np.zeros((3, 2, 2, 3))
    try:
        same, apart, lower = robot_frames(robot, q, ghosts, nothing, 60, 80)
    except NotAvailable as error:
        pytest.skip(str(error))
    orange = [
        (picture[..., 0].astype(int) - picture[..., 2] > 60).sum()
        for picture in (same, apart, lower)
    ]
    assert orange[1] > 50 + max(orange[0], orange[2])
    assert 0.01 < (np.abs(same.astype(int) - lower).max(axis=2) > 20).mean() < 0.6


@pytest.mark.parametrize(("name", "rate"), [("film.mp4", 25.0), ("film.gif", 20.0)])
def test_a_film_has_all_of_a_repetition(
    robot: Robot, run: Run, tmp_path: Path, name: str, rate: float
) -> None:
    clips = [
        make_clip(robot, last_lap(run.log), run.axes, rate=rate, label=label)
        for label in ("iteration 0", "iteration 1")
    ]
    path, steps = tmp_path / name, list[tuple[float, float]]()
    try:
        make_film(robot, clips, path, "a squat", SIZE, lambda *step: steps.append(step))
    except NotAvailable as error:
        pytest.skip(str(error))
    count = sum(len(clip.time) for clip in clips)
    assert count / rate == pytest.approx(2 * 1.0, abs=2 / rate)
    assert steps == [(done + 1, count) for done in range(count)]
    if name.endswith(".gif"):
        with Image.open(path) as film:
            assert film.size == SIZE
            seconds = 0.0
            for place in range(film.n_frames):
                film.seek(place)
                seconds += film.info["duration"] / 1e3
    else:
        import av

        with av.open(path) as film:
            pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
            seconds = len(pictures) / float(film.streams.video[0].average_rate)
        assert pictures[0].shape == (SIZE[1], SIZE[0], 3)
    assert seconds == pytest.approx(count / rate)
    assert [each.name for each in tmp_path.iterdir()] == [name]


def test_a_film_that_is_not_finished_leaves_nothing(
    robot: Robot, clip: Clip, tmp_path: Path
) -> None:
    def stop(done: float, total: float) -> None:
        raise KeyboardInterrupt

    for name in ("film.mp4", "film.gif"):
        try:
            with pytest.raises(KeyboardInterrupt):
                make_film(robot, [clip], tmp_path / name, "", SIZE, stop)
        except NotAvailable as error:
            pytest.skip(str(error))
    assert list(tmp_path.iterdir()) == []


def test_without_a_gl_library_it_says_what_to_install(
    robot: Robot, clip: Clip, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gl_library, "LIBRARIES", ())
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    with pytest.raises(NotAvailable, match=r"GL library.*apt install"):
        make_film(robot, [clip], tmp_path / "film.gif", "", SIZE)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("size", [(239, 180), (240, 181), (238, 180), (240, 1082), (1922, 180)])
def test_a_size_that_no_film_has_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(InvalidValue, match="pixels, even"):
        check_size(size)


@pytest.mark.parametrize("size", [(240, 180), (1920, 1080)])
def test_the_smallest_and_the_largest_film(size: tuple[int, int]) -> None:
    check_size(size)
