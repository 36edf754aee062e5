"""A small humanoid written by the tests: two legs of six joints, a waist, two arms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

BOX_FOOT = '<origin xyz="0.03 0 -0.045"/><geometry><box size="0.2 0.08 0.03"/></geometry>'
# top of the box is 0.03 below the ankle, its bottom 0.06
BOX_SOLE = -0.06
SPHERES = [
    f'<collision><origin xyz="{x} {y} -0.05"/><geometry><sphere radius="0.01"/></geometry>'
    "</collision>"
    for x in (-0.07, 0.13)
    for y in (-0.04, 0.04)
]
LEG = {
    "hip_yaw": ("0 0 1", "-1.0 1.0", 80),
    "hip_roll": ("1 0 0", "-0.8 0.8", 120),
    "hip_pitch": ("0 1 0", "-2.2 1.0", 120),
    "knee": ("0 1 0", "0.0 2.4", 150),
    "ankle_pitch": ("0 1 0", "-1.1 0.9", 90),
    "ankle_roll": ("1 0 0", "-0.5 0.5", 60),
}
DROP = {"knee": -0.32, "ankle_pitch": -0.32}
MASS = {"hip_pitch": 3.0, "knee": 2.0, "ankle_roll": 0.8}


@pytest.fixture
def small_humanoid(tmp_path: Path) -> Callable[..., Path]:
    """Write a small humanoid's URDF into the test's folder; see ``write_humanoid``."""

    def write(*arguments: str, **options: object) -> Path:
        return write_humanoid(tmp_path, *arguments, **options)  # type: ignore[arg-type]

    return write


@pytest.fixture
def geometry_of() -> Callable[[str], str]:
    """Wrap a shape, as URDF, into a collision element 0.05 m below the ankle."""
    return lambda shape: (
        f'<collision><origin xyz="0.03 0 -0.05"/><geometry>{shape}</geometry></collision>'
    )


def write_humanoid(
    folder: Path,
    foot: str = f"<collision>{BOX_FOOT}</collision>",
    *,
    base: str = "0 0 0",
    extra: str = "",
    limits: Mapping[str, str] | None = None,
) -> Path:
    """Write the URDF.

    Args:
        foot: Geometry elements of both feet.
        base: Roll, pitch, yaw from the base link to the pelvis that stands upright.
        extra: Elements to add; ``{side}hand`` are the last links of the arms.
        limits: Other limits than usual, by joint without side.
    """
    parts = [link("base", 0.0), link("pelvis", 8.0), fixed("mount", "base", "pelvis", base)]
    for side, y in (("left_", 0.1), ("right_", -0.1)):
        parent, place = "pelvis", f"0 {y} -0.05"
        for name, (axis, limit, effort) in LEG.items():
            if name in DROP:
                place = f"0 0 {DROP[name]}"
            limit = (limits or {}).get(name, limit)
            child = f"{side}foot" if name == "ankle_roll" else f"{side}{name}_link"
            parts += [
                joint(side + name, parent, child, place, axis, limit, effort),
                link(child, MASS.get(name, 0.6), foot if child.endswith("foot") else ""),
            ]
            parent, place = child, "0 0 0"
    parts += [
        joint("waist", "pelvis", "chest", "0 0 0.1", "0 0 1", "-1 1", 80),
        link("chest", 10.0, com="0 0 0.15"),
    ]
    for side, y in (("left_", 0.2), ("right_", -0.2)):
        parts += [
            joint(f"{side}shoulder", "chest", f"{side}arm", f"0 {y} 0.3", "0 1 0", "-2 2", 40),
            link(f"{side}arm", 1.5, com="0 0 -0.12"),
            joint(f"{side}elbow", f"{side}arm", f"{side}hand", "0 0 -0.25", "0 1 0", "-2.2 0", 30),
            link(f"{side}hand", 1.0, com="0 0 -0.1"),
        ]
    path = folder / "small.urdf"
    path.write_text(f'<robot name="small">{"".join(parts)}{extra}</robot>')
    return path


def link(name: str, mass: float, geometry: str = "", com: str = "0 0 -0.02") -> str:
    inertial = (
        f'<inertial><origin xyz="{com}"/><mass value="{mass}"/><inertia ixx="{0.01 * mass}" '
        f'iyy="{0.01 * mass}" izz="{0.008 * mass}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    return f'<link name="{name}">{inertial if mass else ""}{geometry}</link>'


def fixed(name: str, parent: str, child: str, rpy: str = "0 0 0", xyz: str = "0 0 0") -> str:
    return (
        f'<joint name="{name}" type="fixed"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/></joint>'
    )


def joint(
    name: str,
    parent: str,
    child: str,
    xyz: str,
    axis: str,
    limits: str,
    effort: float,
    kind: str = "revolute",
    more: str = "",
) -> str:
    low, high = limits.split()
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>'
        f'<limit lower="{low}" upper="{high}" effort="{effort}" velocity="10"/>{more}</joint>'
    )
