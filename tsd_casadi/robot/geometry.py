"""The shapes that a description gives its links: what is seen, and what collides."""

from __future__ import annotations

import copy
import tempfile
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal
from xml.etree import ElementTree

import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.captured_stderr import captured_stderr
from tsd_casadi.robot.description import Description
from tsd_casadi.robot.mesh_path import find_mesh
from tsd_casadi.robot.rigid_body_model import RigidBodyModel

Use = Literal["visual", "collision"]


@dataclass(frozen=True)
class Geometry:
    """Shapes on the bodies of a robot's model.

    Attributes:
        model: ``pinocchio.GeometryModel``; parent joints are those of
            ``RigidBodyModel.model``.
        missing: Mesh files that the description names and that are not there.
    """

    model: Any
    missing: tuple[str, ...]


def load_geometry(
    bodies: RigidBodyModel, use: Use, links: Collection[str] | None = None
) -> Geometry:
    """Load the shapes of links, meshes included.

    Locked joints are at their angles. Meshes that are missing are left out.

    Args:
        use: What the shapes are for.
        links: Whose shapes are wanted, all by default; reading meshes takes time.

    Raises:
        RobotFileError: If a mesh that is there cannot be read.
    """
    return _load(bodies, copy.deepcopy(bodies.description), use, links)


def load_primitives(bodies: RigidBodyModel, links: Collection[str]) -> Any:
    """Load the collision shapes of links that are boxes, spheres and the like, no meshes.

    Returns:
        ``pinocchio.GeometryModel``; parent joints are those of ``RigidBodyModel.model``.
    """
    description = copy.deepcopy(bodies.description)
    if description.kind == "urdf":
        for link in description.links().values():
            for shape in link.findall("collision"):
                if shape.find("geometry/mesh") is not None:
                    link.remove(shape)
    else:
        _drop_geoms(description.root, None)
    return _load(bodies, description, "collision", links).model


def _load(
    bodies: RigidBodyModel, description: Description, use: Use, links: Collection[str] | None
) -> Geometry:
    build = _of_urdf if description.kind == "urdf" else _of_mjcf
    try:
        with captured_stderr():
            full, missing = build(bodies.full, description, use, links)
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise RobotFileError(
            description.path,
            "",
            f"names a mesh that cannot be read ({reason})",
            "STL, OBJ or Collada files",
        ) from error
    _, (reduced,) = pinocchio.buildReducedModel(
        bodies.full, [full], bodies.locked, bodies.locked_at
    )
    return Geometry(reduced, tuple(dict.fromkeys(missing)))


def _of_urdf(
    model: Any, description: Description, use: Use, links: Collection[str] | None
) -> tuple[Any, list[str]]:
    missing = []
    for name, link in description.links().items():
        wanted = links is None or name in links
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            mesh = shape.find("geometry/mesh")
            if shape.tag != use or not wanted:
                link.remove(shape)
            elif mesh is not None:
                written = mesh.get("filename", "")
                found = find_mesh(description.path, written)
                if found is None:
                    missing.append(written)
                    link.remove(shape)
                else:
                    mesh.set("filename", str(found))
    kind = pinocchio.GeometryType.VISUAL if use == "visual" else pinocchio.GeometryType.COLLISION
    return pinocchio.buildGeomFromUrdfString(model, description.text, kind), missing


def _of_mjcf(
    model: Any, description: Description, use: Use, links: Collection[str] | None
) -> tuple[Any, list[str]]:
    root = description.root
    missing = []
    for asset in root.findall("asset"):
        for mesh in asset.findall("mesh"):
            place = _mesh_folder(root, description.path) / mesh.get("file", "")
            if mesh.get("file") and not place.is_file():
                missing.append(mesh.get("file", ""))
                asset.remove(mesh)
                _drop_geoms(root, mesh.get("name") or place.stem)
    if links is not None:
        for name, body in description.links().items():
            if name not in links:
                for geom in body.findall("geom"):
                    body.remove(geom)
    kind = pinocchio.GeometryType.VISUAL if use == "visual" else pinocchio.GeometryType.COLLISION
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / description.path.name
        place.write_text(description.text, encoding="utf-8")
        return pinocchio.buildGeomFromMJCF(model, str(place), kind), missing


def _mesh_folder(root: ElementTree.Element, path: Path) -> Path:
    """Find the folder that mesh files are relative to."""
    compiler = root.find("compiler")
    named = "" if compiler is None else compiler.get("meshdir") or compiler.get("assetdir") or ""
    return path.parent / named


def _drop_geoms(root: ElementTree.Element, mesh: str | None) -> None:
    """Remove the geoms of one mesh, or of every mesh."""
    for body in root.iter("body"):
        for geom in body.findall("geom"):
            named = geom.get("mesh")
            if named is not None and mesh in (None, named):
                body.remove(geom)
