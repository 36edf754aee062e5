"""The flat patch under a foot, against sizes written into the description."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.proposal.soles import INSIDE
from tsd_casadi.proposal.survey import survey
from tsd_casadi.robot.convex_polygon import area, hull, largest_rectangle
from tsd_casadi.robot.sole_patch import FLATNESS, SolePatch

FEET = ("left_foot", "right_foot")
Write = Callable[..., Path]
Shape = Callable[[str], str]


def left_sole(path: Path, feet: tuple[str, str] = FEET) -> SolePatch:
    return survey(path, feet, ()).body.soles[0]


def whole(sole: SolePatch) -> tuple[float, float]:
    """Length and width of the patch, of which the proposal takes a share."""
    return tuple(float(np.ptp(side)) / INSIDE for side in (sole.x, sole.y))


def test_a_box_is_its_bottom(small_humanoid: Write) -> None:
    sole = left_sole(small_humanoid())
    np.testing.assert_allclose(whole(sole), (0.2, 0.08), atol=1e-9)
    np.testing.assert_allclose(sole.placement.translation, (0, 0, -0.06), atol=1e-9)
    np.testing.assert_allclose(sole.placement.rotation, np.eye(3), atol=1e-9)
    assert np.mean(sole.x) == pytest.approx(0.03)
    assert (sole.frame, sole.source) == ("left_foot", "collision")
    assert sole.named_height == pytest.approx(0.06)


def test_four_spheres_are_the_hull_of_their_lowest_points(small_humanoid: Write) -> None:
    spheres = "".join(
        f'<collision><origin xyz="{x} {y} -0.05"/><geometry><sphere radius="0.01"/></geometry>'
        "</collision>"
        for x in (-0.07, 0.13)
        for y in (-0.04, 0.04)
    )
    sole = left_sole(small_humanoid(spheres))
    np.testing.assert_allclose(whole(sole), (0.2, 0.08), atol=1e-9)
    np.testing.assert_allclose(sole.placement.translation[2], -0.06, atol=1e-9)


def test_a_cylinder_on_its_end_holds_a_square(small_humanoid: Write, geometry_of: Shape) -> None:
    sole = left_sole(small_humanoid(geometry_of('<cylinder radius="0.05" length="0.02"/>')))
    # of all rectangles in a circle the square is the largest
    np.testing.assert_allclose(whole(sole), (0.1 / math.sqrt(2),) * 2, rtol=0.03)
    np.testing.assert_allclose(sole.placement.translation[2], -0.06, atol=1e-9)


@pytest.mark.parametrize(
    "shape", ['<sphere radius="0.04"/>', '<cylinder radius="0.08" length="0.1"/>']
)
def test_what_touches_in_a_point_or_a_line_is_refused(
    small_humanoid: Write, geometry_of: Shape, shape: str
) -> None:
    lying = geometry_of(shape).replace("<origin ", '<origin rpy="0 1.5707963 0" ')
    with pytest.raises(RobotFileError, match="touches in a point or a line") as refused:
        left_sole(small_humanoid(lying))
    assert "left_foot" in str(refused.value)


def test_a_foot_without_geometry_is_refused(small_humanoid: Write) -> None:
    with pytest.raises(RobotFileError, match="no collision geometry and no visual geometry"):
        left_sole(small_humanoid(""))


def test_what_is_drawn_stands_in_for_what_collides(
    small_humanoid: Write, geometry_of: Shape
) -> None:
    drawn = geometry_of('<box size="0.2 0.08 0.02"/>').replace("collision", "visual")
    found = survey(small_humanoid(drawn), FEET, ())
    assert found.body.soles[0].source == "visual"
    assert any("what is drawn was taken" in note for note in found.notes)


def test_a_frame_on_the_patch_is_named_instead(small_humanoid: Write) -> None:
    extra = _frames(-0.06)
    sole = left_sole(small_humanoid(extra=extra))
    assert (sole.frame, sole.is_frame) == ("left_mark", True)


@pytest.mark.parametrize(("height", "is_frame"), [(-0.0591, True), (-0.0589, False)])
def test_a_frame_coincides_within_a_millimetre(
    small_humanoid: Write, height: float, is_frame: bool
) -> None:
    assert left_sole(small_humanoid(extra=_frames(height))).is_frame is is_frame


def test_a_frame_a_centimetre_above_the_sole_is_told(small_humanoid: Write) -> None:
    found = survey(small_humanoid(extra=_frames(-0.05)), ("left_mark", "right_mark"), ())
    assert found.body.soles[0].frame == "left_mark"
    np.testing.assert_allclose(found.body.soles[0].placement.translation[2], -0.01, atol=1e-9)
    assert any("left_mark is 10.0 mm above" in note for note in found.notes)


def test_an_ankle_is_not_taken_for_a_foot(small_humanoid: Write) -> None:
    ankles = ("left_ankle_pitch_link", "right_ankle_pitch_link")
    with pytest.raises(RobotFileError, match="left_ankle_roll moves what is below"):
        survey(small_humanoid(), ankles, ())


@pytest.mark.parametrize(("dent", "counts"), [(0.9 * FLATNESS, True), (1.1 * FLATNESS, False)])
def test_a_mesh_is_flat_to_two_millimetres(
    small_humanoid: Write, geometry_of: Shape, tmp_path: Path, dent: float, counts: bool
) -> None:
    """A toe that is a little higher belongs to the sole, a higher one does not."""
    corners = [(-0.1, 0.0), (0.06, 0.0), (0.1, dent)]
    _write_stl(tmp_path / "foot.stl", corners)
    foot = geometry_of('<mesh filename="foot.stl"/>').replace("-0.05", "-0.06")
    path = small_humanoid(foot.replace("foot.stl", f"file://{tmp_path}/foot.stl"))
    length, width = whole(left_sole(path))
    assert width == pytest.approx(0.08, abs=1e-6)
    assert length == pytest.approx(0.2 if counts else 0.16, abs=2e-3)


def _frames(height: float) -> str:
    return "".join(
        f'<link name="{side}_mark"/><joint name="{side}_mark_mount" type="fixed">'
        f'<parent link="{side}_foot"/><child link="{side}_mark"/>'
        f'<origin xyz="0 0 {height}"/></joint>'
        for side in ("left", "right")
    )


def _write_stl(path: Path, profile: list[tuple[float, float]]) -> None:
    """Write a prism: a profile (x, z) of the underside, 0.08 m wide, 0.03 m high."""
    top = [(x, 0.03) for x, _ in profile]
    quads = []
    for side in zip(profile, profile[1:], top[1:], top, strict=False):
        quads += [[(x, y, z) for x, z in side] for y in (-0.04, 0.04)]
    for (x0, z0), (x1, z1) in [*pairwise(profile), *pairwise(top)]:
        quads.append([(x0, -0.04, z0), (x1, -0.04, z1), (x1, 0.04, z1), (x0, 0.04, z0)])
    triangles = [(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads]
    content = b"\0" * 80 + struct.pack("<I", len(triangles))
    for triangle in triangles:
        numbers = (0.0, 0.0, 0.0, *(value for corner in triangle for value in corner))
        content += struct.pack("<12fH", *numbers, 0)
    path.write_bytes(content)


points = st.tuples(st.floats(-1, 1), st.floats(-1, 1))


@given(st.lists(points, min_size=3, max_size=12, unique=True))
def test_the_largest_rectangle_is_inside_and_worth_half_of_a_polygon(
    corners: list[tuple[float, float]],
) -> None:
    """Of a convex polygon at least half of its area fits (Radziszewski 1952, for any angle)."""
    polygon = hull(np.array(corners))
    if len(polygon) < 3 or area(polygon) < 1e-2:
        return
    x, y = largest_rectangle(polygon)
    edges = np.roll(polygon, -1, axis=0) - polygon
    inwards = np.column_stack((-edges[:, 1], edges[:, 0]))
    for corner in ((a, b) for a in x for b in y):
        assert np.min(np.sum(inwards * (np.array(corner) - polygon), axis=1)) > -1e-9
    assert (x[1] - x[0]) * (y[1] - y[0]) > 0


def test_the_largest_rectangle_of_a_rhombus_is_half_of_it() -> None:
    rhombus = hull(np.array([(-1.0, 0.0), (0.0, -0.5), (1.0, 0.0), (0.0, 0.5)]))
    x, y = largest_rectangle(rhombus)
    assert (x[1] - x[0]) * (y[1] - y[0]) == pytest.approx(0.5 * area(rhombus), rel=1e-3)


def test_a_missing_mesh_is_named(small_humanoid: Write, geometry_of: Shape) -> None:
    gone = geometry_of('<mesh filename="package://nowhere/foot.stl"/>')
    with pytest.raises(RobotFileError, match=r"package://nowhere/foot\.stl"):
        left_sole(small_humanoid(gone))
