"""Which GL library draws without a screen.

MuJoCo chooses its GL library when it is imported, so each library is tried in
a process of its own; a missing or broken one then costs a picture and nothing
else.
"""

from __future__ import annotations

import os

LIBRARIES = ("egl", "osmesa")
# MuJoCo's word for a process that renders nothing itself
NO_LIBRARY = "disable"
HINT = (
    "No picture of the robot: no GL library for offscreen rendering was found; "
    "'apt install libosmesa6' (or libegl1) provides one."
)
# how the drawing process ends where a library is not to blame
REFUSED = 3


def libraries() -> tuple[str, ...]:
    """List what to try: first what the user has chosen."""
    chosen = os.environ.get("MUJOCO_GL")
    return (chosen, *LIBRARIES) if chosen and chosen != NO_LIBRARY else LIBRARIES


def environment_with(library: str) -> dict[str, str]:
    """Make the environment of a process that draws with a library."""
    return {**os.environ, "MUJOCO_GL": library}
