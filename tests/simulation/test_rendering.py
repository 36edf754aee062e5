from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi import Robot
from tsd_casadi.robot.standing import stand
from tsd_clients.viewer import rendering
from tsd_clients.viewer.rendering import HINT, render_postures, side_by_side


def test_a_lower_posture_is_a_lower_picture(robot: Robot) -> None:
    postures = np.array([stand(robot, height).q for height in (0.05, -0.05)])
    frames = render_postures(robot, postures, 60, 80)
    if frames is None:
        pytest.skip(HINT)
    assert frames.shape == (2, 80, 60, 3)
    assert frames.dtype == np.uint8
    # the same place is seen, something in it has moved
    assert 0 < np.mean(frames[0] != frames[1]) < 0.6
    assert side_by_side(frames).shape == (80, 120, 3)


def test_a_library_that_does_not_work_costs_no_more_than_the_picture(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rendering, "LIBRARIES", ("none",))
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    assert render_postures(robot, robot.home.q[None, :]) is None


@pytest.mark.parametrize(
    ("chosen", "tried"),
    [("", rendering.LIBRARIES), ("disable", rendering.LIBRARIES), ("a", ("a", "egl", "osmesa"))],
)
def test_the_users_library_is_tried_first(
    robot: Robot, monkeypatch: pytest.MonkeyPatch, chosen: str, tried: tuple[str, ...]
) -> None:
    libraries: list[str] = []
    monkeypatch.setenv("MUJOCO_GL", chosen)
    monkeypatch.setattr(rendering, "_render_apart", lambda library, *_: libraries.append(library))
    assert render_postures(robot, robot.home.q[None, :]) is None
    assert tuple(libraries) == tried
