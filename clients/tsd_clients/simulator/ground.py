"""What soles touch, and how: the same stiff contacts under every robot."""

from __future__ import annotations

from typing import Any

import mujoco

FLOOR = "floor"
# sliding [-], torsional [m] and rolling [m]; robots count on less
FRICTION = (0.8, 0.02, 0.0001)
# normal force, two of sliding friction and torsional friction
CONDIM = 4
# time constant [s] and damping ratio of a contact: four steps, so it is stiff and
# yet smooth to integrate
SOLREF = (0.004, 1.0)
# impedance from 0.95 to 0.99 within 1 mm of depth
SOLIMP = (0.95, 0.99, 0.001, 0.5, 2.0)
# half an edge of what is drawn, the plane itself has no end [m]
DRAWN = 4.0
COLOR = (0.76, 0.78, 0.81, 1.0)


def contact_options() -> dict[str, Any]:
    """Give the options of a geom that carries the robot's weight."""
    return {
        "condim": CONDIM,
        "friction": FRICTION,
        "solref": SOLREF,
        "solimp": SOLIMP,
    }


def add_floor(spec: Any) -> None:
    """Add the ground plane z = 0.

    Args:
        spec: ``mujoco.MjSpec``.
    """
    spec.worldbody.add_geom(
        name=FLOOR,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(DRAWN, DRAWN, 0.1),
        rgba=COLOR,
        contype=1,
        conaffinity=0,
        **contact_options(),
    )
