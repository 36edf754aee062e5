"""Whether a scene's bodies have the description's masses, inertias and placements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions.discrepancy import Discrepancy
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_clients.simulator.build_scene import BASE, joint_axis
from tsd_clients.simulator.rounding import NOTHING, TOLERANCE
from tsd_clients.simulator.scene_bodies import HINGE, SceneBodies, SceneBody

ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
KINDS = {True: "a hinge", False: "a slide"}


@dataclass(frozen=True)
class BodyParity:
    """How a scene's bodies compare with the description's.

    Attributes:
        discrepancies: What differs, from the base outwards.
        displacements: ``pinocchio.SE3`` by Pinocchio's joint: what carries a body of
            the description to where misplaced parents put the scene's.
    """

    discrepancies: list[Discrepancy]
    displacements: list[Any]


def compare_bodies(robot: Robot, scene: SceneBodies) -> BodyParity:
    """Compare body by body, with all joints at zero.

    What hangs on a misplaced body is compared relative to it, so that only the
    body to blame is named.
    """
    model = robot.model
    data = model.createData()
    pinocchio.forwardKinematics(model, data, pinocchio.neutral(model))
    found: list[Discrepancy] = []
    displacements = [pinocchio.SE3.Identity() for _ in range(model.njoints)]
    for joint in range(BASE, model.njoints):
        name = "" if joint == BASE else model.names[joint]
        body, parent = scene.bodies[name], model.parents[joint]
        comparison = _Comparison(robot, joint, body, data.oMi[joint])
        inherited = displacements[parent]
        # where the scene's own frame is: scenes made from a description keep its frames
        own = body.frame * data.oMi[joint].inverse()
        misplaced = comparison.placement(inherited)
        if misplaced and joint != BASE and not comparison.placement(own):
            found.append(comparison.displaced(inherited, data.oMi[parent]))
            displacements[joint] = own
        else:
            found += misplaced
            displacements[joint] = inherited
        found += comparison.structure(model.names[parent] if parent != BASE else "")
        found += comparison.mass()
    return BodyParity(found, displacements)


class _Comparison:
    """One joint and what it moves, in scene and description."""

    def __init__(self, robot: Robot, joint: int, body: SceneBody, placement: Any) -> None:
        self._robot, self._joint, self._body, self._placement = robot, joint, body, placement
        self._inertia = robot.model.inertias[joint]
        self._name = f"joint {robot.model.names[joint]}"
        self._length = float(robot.home_com[2])
        self._total = robot.weight / float(np.linalg.norm(robot.model.gravity.linear))

    def mass(self) -> list[Discrepancy]:
        """Compare the masses."""
        found, expected = self._body.inertia.mass, self._inertia.mass
        if abs(found - expected) <= max(TOLERANCE * expected, NOTHING * self._total):
            return []
        remedy = (
            f'set mass="{expected:.9g}" there, or correct the description (links on fixed or '
            "locked joints count with the body that carries them)"
        )
        return [self._of_body("mass", f"{found:.9g} kg", f"{expected:.9g} kg", remedy)]

    def structure(self, parent: str) -> list[Discrepancy]:
        """Compare what the joint hangs on."""
        if self._joint == BASE or self._body.parent == parent:
            return []
        found, expected = (
            f"the body of joint {name}" if name else "the base"
            for name in (self._body.parent, parent)
        )
        return [Discrepancy(self._name, "what it hangs on", found, expected, "move its body")]

    def placement(self, displacement: Any) -> list[Discrepancy]:
        """Compare everything that depends on where the body is."""
        placement = displacement * self._placement
        return [*self._axis(placement), *self._inertial(placement)]

    def displaced(self, inherited: Any, parent: Any) -> Discrepancy:
        """Describe a body whose frame is not where the description has the joint's."""
        expected = self._robot.model.jointPlacements[self._joint]
        found = (inherited * parent).inverse() * self._body.frame
        turned = float(np.linalg.norm(pinocchio.log3(expected.rotation.T @ found.rotation)))
        remedy = "set its pos and quat to the description's origin of the joint"
        if turned > TOLERANCE:
            remedy += f" (it is turned by {turned:.6f} rad)"
        return self._of_body(
            "placement on its parent",
            f"({_numbers(found.translation)}) m",
            f"({_numbers(expected.translation)}) m"
            + (f" and turned by {turned:.6f} rad less" if turned > TOLERANCE else ""),
            remedy,
        )

    def _axis(self, placement: Any) -> list[Discrepancy]:
        if self._joint == BASE:
            return []
        body = self._body
        axis, kind = joint_axis(self._robot, self._joint)
        hinge = int(kind) == HINGE
        if (body.kind == HINGE) != hinge:
            kinds = KINDS[body.kind == HINGE], KINDS[hinge]
            return [Discrepancy(self._name, "its kind", *kinds, "set its type")]
        found = placement.rotation.T @ body.axis
        if np.linalg.norm(found - axis) > TOLERANCE:
            remedy = f'set axis="{_numbers(axis)}" in the frame of its link'
            vectors = f"({_numbers(found)})", f"({_numbers(axis)})"
            return [Discrepancy(self._name, "axis", *vectors, remedy)]
        anchor = placement.actInv(body.anchor)
        off = anchor - axis * (axis @ anchor)  # a point of the axis may be any
        if hinge and np.linalg.norm(off) > TOLERANCE * self._length:
            remedy = "set the joint's pos to 0 0 0, or the body's to the description's origin"
            line = f"{1e3 * np.linalg.norm(off):.3f} mm beside the description's", "on it"
            return [Discrepancy(self._name, "place of its axis", *line, remedy)]
        return []

    def _inertial(self, placement: Any) -> list[Discrepancy]:
        expected = self._inertia
        if expected.mass <= NOTHING * self._total:
            return []
        found = placement.inverse().act(self._body.inertia)
        differences = []
        if np.linalg.norm(found.lever - expected.lever) > TOLERANCE * self._length:
            vectors = f"({_numbers(found.lever)}) m", f"({_numbers(expected.lever)}) m"
            remedy = "set the pos of its inertial, in the link's frame"
            differences.append(self._of_body("centre of mass", *vectors, remedy))
        off = np.abs(found.inertia - expected.inertia)
        nothing = NOTHING * self._total * self._length**2
        if off.max() > max(TOLERANCE * np.abs(expected.inertia).max(), nothing):
            entry = max(ENTRIES, key=lambda name: off[ENTRIES[name]])
            row, column = ENTRIES[entry]
            values = (
                f"{found.inertia[row, column]:.9g} kg m^2",
                f"{expected.inertia[row, column]:.9g} kg m^2",
            )
            order = " ".join(f"{expected.inertia[place]:.9g}" for place in ENTRIES.values())
            remedy = f'set fullinertia="{order}" with quat 1 0 0 0 in the link\'s axes'
            quantity = f"{entry} about its centre of mass"
            differences.append(self._of_body(quantity, *values, remedy))
        return differences

    def _of_body(self, quantity: str, found: str, expected: str, remedy: str) -> Discrepancy:
        return Discrepancy(f"body {self._body.name}", quantity, found, expected, remedy)


def _numbers(vector: Vector) -> str:
    return " ".join(f"{x + 0.0:.6g}" for x in np.round(vector, 9))
