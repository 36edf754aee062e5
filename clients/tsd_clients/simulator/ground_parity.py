"""Whether the controller can rely on a scene's floor and on the feet that stand on it."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pinocchio

from tsd_casadi.exceptions.discrepancy import Discrepancy
from tsd_casadi.robot.checks import FLATNESS
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import Contact, SoleFile
from tsd_casadi.state import Vector
from tsd_clients.simulator.foot_points import foot_points
from tsd_clients.simulator.rounding import TOLERANCE
from tsd_clients.simulator.scene_bodies import SceneBodies
from tsd_clients.simulator.state_map import StateMap

# in which a sole is compared with the controller's: a degree apart
DIRECTIONS = np.stack([f(np.linspace(0, 2 * np.pi, 360, False)) for f in (np.cos, np.sin)])


def compare_ground(
    robot: Robot, model: Any, scene: SceneBodies, displacements: list[Any]
) -> list[Discrepancy]:
    """Compare floor and feet with what the controller counts on.

    Lengths may be off by as much as a home posture may leave soles off the ground.

    Args:
        model: ``mujoco.MjModel``.
        displacements: By Pinocchio's joint, of bodies that are known to be misplaced.
    """
    floors = [g for g in range(model.ngeom) if _is_ground(model, g) and _collides(model, g)]
    if not floors:
        floor = (
            '<geom name="floor" type="plane" size="4 4 0.1" condim="4" friction="0.8 0.02 0.0001"/>'
        )
        values = "missing", "something to stand on", f"add {floor} to its worldbody"
        return [Discrepancy("world", "the floor", *values)]
    found = _level(model, scene.data, floors)
    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, pinocchio.neutral(robot.model))
    homes = robot.sole_placements(robot.home.q)
    for contact, foot, home in zip(robot.description.contacts, robot.feet, homes, strict=True):
        joint = robot.model.frames[foot.frame].parentJoint
        sole = displacements[joint] * data.oMf[foot.frame] * foot.upright(home)
        name = robot.model.names[joint] if joint > 1 else ""
        bodies = [body for body, mover in enumerate(scene.joint_of) if mover == name]
        feet = [
            (geom, [floor for floor in floors if _collide(model, geom, floor)])
            for body in bodies
            for geom in _geoms(model, body)
        ]
        feet = [(geom, below) for geom, below in feet if below]
        if not feet:
            names = ", ".join(model.body(body).name for body in bodies)
            remedy = "add a geom there whose contype or conaffinity the floor's other one shares"
            values = "missing", f"a geom of body {names} that collides with the floor", remedy
            found.append(Discrepancy(f"contact {contact.name}", "the foot", *values))
            continue
        found += _friction(model, contact, feet)
        points = np.vstack([foot_points(model, scene.data, geom, sole) for geom, _ in feet])
        found += _sole(contact, points)
    return found + _touching(robot, model, floors)


def _level(model: Any, data: Any, floors: list[int]) -> list[Discrepancy]:
    """See to a floor on which the robot starts: a plane, else the top of a box."""
    kinds = mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_BOX
    flat = [[geom for geom in floors if model.geom_type[geom] == kind] for kind in kinds]
    candidates = flat[0] or flat[1]
    if not candidates:
        return []  # terrain is the user's own business
    off = {}
    for geom in candidates:
        normal = data.geom_xmat[geom].reshape(3, 3)[:, 2]
        thickness = model.geom_size[geom, 2] if geom in flat[1] else 0.0
        height = float(normal @ data.geom_xpos[geom] + thickness)
        off[geom] = height, float(np.linalg.norm(normal[:2]))
    nearest = min(off, key=lambda geom: max(map(abs, off[geom])))
    height, tilt = off[nearest]
    if max(abs(height), tilt) <= FLATNESS:
        return []
    values = f"{1e3 * height:.1f} mm high, tilted by {tilt:.4f} rad", "the plane z = 0"
    name = model.geom(nearest).name or f"number {nearest}"
    remedy = "put its surface on z = 0, level: that is where the robot starts"
    return [Discrepancy(f"geom {name}", "the floor", *values, remedy)]


def _friction(model: Any, contact: Contact, feet: list[tuple[int, list[int]]]) -> list[Discrepancy]:
    least = min(_sliding(model, geom, floor) for geom, below in feet for floor in below)
    if least >= contact.friction * (1 - TOLERANCE):
        return []
    return [
        Discrepancy(
            f"contact {contact.name}",
            "friction between foot and floor",
            f"{least:g}",
            f"at least {contact.friction:g}, which the controller counts on",
            "raise the geoms' friction, or lower that of the contact in the robot file",
        )
    ]


def _sole(contact: Contact, points: Any) -> list[Discrepancy]:
    element = f"contact {contact.name}"
    lowest = float(points[:, 2].min())
    under = points[points[:, 2] < lowest + FLATNESS, :2]
    found = []
    if abs(lowest) > FLATNESS:
        way = "above" if lowest > 0 else "below"
        values = f"{1e3 * abs(lowest):.1f} mm {way} frame {contact.frame}", "at that frame"
        remedy = "move the foot's geom, or the contact with its offset in the robot file"
        found.append(Discrepancy(element, "the underside of the foot", *values, remedy))
    if isinstance(contact, SoleFile):
        corners = np.array([(x, y) for x in contact.x for y in contact.y])
    else:
        corners = np.zeros((1, 2))
    reach = (under @ DIRECTIONS).max(axis=0)
    if (corners @ DIRECTIONS - reach).max() > FLATNESS:
        values = _extents(under), _extents(corners) + " at least"
        remedy = "widen the foot's geom, or make the contact in the robot file smaller"
        found.append(Discrepancy(element, "the sole in its frame", *values, remedy))
    return found


def _touching(robot: Robot, model: Any, floors: list[int]) -> list[Discrepancy]:
    """Find what touches at home besides feet and floor: forces that nobody expects."""
    data = mujoco.MjData(model)
    StateMap(robot, model).write(data, robot.home)
    mujoco.mj_forward(model, data)
    pairs = {}
    for contact in data.contact:
        if contact.dist < -FLATNESS and not set(map(int, contact.geom)) & set(floors):
            names = sorted(model.body(model.geom_bodyid[geom]).name for geom in contact.geom)
            pairs[tuple(names)] = float(-contact.dist)
    remedy = "exclude the pair, or give their geoms contype and conaffinity 0"
    return [
        Discrepancy(
            f"bodies {one} and {other}",
            "their overlap at home",
            f"{1e3 * depth:.1f} mm",
            "none",
            remedy,
        )
        for (one, other), depth in pairs.items()
    ]


def _extents(points: Vector) -> str:
    (x, y), (X, Y) = points.min(axis=0), points.max(axis=0)
    return f"x [{x:.4g} {X:.4g}], y [{y:.4g} {Y:.4g}] m"


def _is_ground(model: Any, geom: int) -> bool:
    return bool(model.body_weldid[model.geom_bodyid[geom]] == 0)


def _geoms(model: Any, body: int) -> range:
    first = int(model.body_geomadr[body])
    return range(first, first + int(model.body_geomnum[body]))


def _pair(model: Any, one: int, other: int) -> int | None:
    for index in range(model.npair):
        if {one, other} == {int(model.pair_geom1[index]), int(model.pair_geom2[index])}:
            return index
    return None


def _collides(model: Any, geom: int) -> bool:
    return any(_collide(model, geom, other) for other in range(model.ngeom) if other != geom)


def _collide(model: Any, one: int, other: int) -> bool:
    """Tell whether MuJoCo looks for contacts between two geoms of different bodies."""
    if _pair(model, one, other) is not None:
        return True
    bodies = sorted(int(model.geom_bodyid[geom]) for geom in (one, other))
    if (bodies[0] << 16) + bodies[1] in model.exclude_signature:
        return False
    contype, conaffinity = model.geom_contype, model.geom_conaffinity
    return bool(contype[one] & conaffinity[other] or contype[other] & conaffinity[one])


def _sliding(model: Any, one: int, other: int) -> float:
    """Compute the sliding friction of two geoms as MuJoCo does."""
    pair = _pair(model, one, other)
    if pair is not None:
        return float(model.pair_friction[pair, 0])
    first, second = model.geom_priority[one], model.geom_priority[other]
    if first != second:
        return float(model.geom_friction[one if first > second else other, 0])
    return float(max(model.geom_friction[one, 0], model.geom_friction[other, 0]))
