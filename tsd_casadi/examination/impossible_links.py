"""Links of a URDF whose mass or inertia no body can have, those that are fixed to others too.

The model adds the links that are fixed to each other; one that cannot be is hidden
by the rest, and comes to light when the joint between them is set free.
"""

from __future__ import annotations

from collections.abc import Iterator

from tsd_casadi.examination.finding import Finding
from tsd_casadi.robot.description import Description
from tsd_casadi.robot.inertias import override_lines, what_is_wrong, written_inertia

# what carries an inertia that is no number, or a sensor's frame with next to no mass,
# moves nothing [kg]
SLIGHT = 0.02


def impossible_links(description: Description, robot_file: str) -> Iterator[Finding]:
    """Find links that cannot be, each with the line for the robot file.

    Args:
        robot_file: Its name, for the remedy.
    """
    if description.kind != "urdf":
        return
    for name, link in description.links().items():
        inertia = written_inertia(link)
        if inertia is None:
            continue
        wrong = what_is_wrong(inertia)
        if wrong is None:
            continue
        slight = 0 <= inertia.mass <= SLIGHT
        yield Finding(
            "note" if slight else "warning",
            f"link {name}",
            wrong,
            f"in {robot_file}: {override_lines(name, inertia)}",
        )
