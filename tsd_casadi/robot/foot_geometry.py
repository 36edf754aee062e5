"""Collision and visual geometry of some links of a description, nothing else of it loaded."""

from __future__ import annotations

from collections.abc import Collection
from copy import deepcopy
from pathlib import Path
from typing import Any

import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.description import Description
from tsd_casadi.robot.rigid_body_model import RigidBodyModel

KINDS = {
    "collision": pinocchio.GeometryType.COLLISION,
    "visual": pinocchio.GeometryType.VISUAL,
}


def foot_geometry(
    description: Description, bodies: RigidBodyModel, joints: Collection[int]
) -> dict[str, Any]:
    """Load the geometry of what some joints carry.

    Args:
        joints: Their indices in ``bodies.model``.

    Returns:
        ``pinocchio.GeometryModel`` for ``bodies.model``, by 'collision' and 'visual'.

    Raises:
        RobotFileError: If a mesh of those links is missing or cannot be read.
    """
    links = {
        frame.name
        for frame in bodies.model.frames
        if frame.parentJoint in joints and frame.type == pinocchio.FrameType.BODY
    }
    loaded = {}
    for kind, of_kind in KINDS.items():
        try:
            if description.kind == "urdf":
                geometry = pinocchio.buildGeomFromUrdfString(
                    bodies.full,
                    _only(description, links),
                    of_kind,
                    package_dirs=package_folders(description.path),
                )
            else:
                geometry = pinocchio.buildGeomFromMJCF(bodies.full, str(description.path), of_kind)
        except (ValueError, RuntimeError) as error:
            reason = " ".join(str(error).split())
            raise RobotFileError(
                description.path,
                f"{kind} geometry of {', '.join(sorted(links))}",
                f"cannot be loaded ({reason})",
                "meshes where the description names them: package://NAME/ is a folder NAME "
                "that the description lies in, or next to such a folder",
            ) from error
        _, reduced = pinocchio.buildReducedModel(
            bodies.full, geometry, bodies.locked, bodies.locked_at
        )
        loaded[kind] = reduced
    return loaded


def package_folders(path: Path) -> list[str]:
    """List where packages may be that a description names: the folders it lies in."""
    return [str(folder) for folder in path.resolve().parents]


def _only(description: Description, links: Collection[str]) -> str:
    """Leave the geometry of other links out: their meshes are large, or missing."""
    root = deepcopy(description.root)
    for link in root.iter("link"):
        if link.get("name") not in links:
            for tag in ("visual", "collision"):
                for element in link.findall(tag):
                    link.remove(element)
    return Description(description.path, description.kind, root).text
