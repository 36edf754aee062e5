"""A corrected centre of mass as JSON."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from tsd_casadi.document import Document, Finite, Name

MOST_LINKS = 200


class CenterOfMassMessage(Document):
    """The vectors of a statically equivalent serial chain; see ``static_chain``.

    Attributes:
        format: Name and version of this message.
        robot: Name of the robot.
        fingerprint: Of the robot file and URDF that it corrects.
        links: Names of the joints that carry the links.
        terms: r_i in the links' frames [m].
        covariance: Of the terms one after another [m^2].
    """

    format: Literal["tsd.center_of_mass/1"] = "tsd.center_of_mass/1"
    robot: Name
    fingerprint: Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]
    links: Annotated[tuple[Name, ...], Field(min_length=1, max_length=MOST_LINKS)]
    terms: Annotated[list[list[Finite]], Field(max_length=MOST_LINKS)]
    covariance: Annotated[list[list[Finite]], Field(max_length=3 * MOST_LINKS)]
