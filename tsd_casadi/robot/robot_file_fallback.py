"""The section of a robot file on what a client does while no torque comes."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Tag

from tsd_casadi.robot.robot_file_sections import NonNegative, Positive, Section


class HoldFile(Section):
    """Hold the posture in which the torques stopped, against gravity.

    Attributes:
        kind: Always 'hold', and so where it is left out.
        P: Joint stiffness about that posture [N m/rad]; by default from the robot's
            weight, height and inertias, see ``tsd_casadi.fallback.hold_gains``.
        D: Joint damping [N m s/rad]; by default as P.
    """

    kind: Literal["hold"] = "hold"
    P: NonNegative | None = None
    D: NonNegative | None = None


class DecayFile(Section):
    """Let the last torque decay.

    Attributes:
        kind: Always 'decay'.
        time: After which 37 % of it are left [s].
    """

    kind: Literal["decay"]
    time: Positive


class ZeroFile(Section):
    """Apply no torque.

    Attributes:
        kind: Always 'zero'.
    """

    kind: Literal["zero"]


def _kind_of_fallback(section: object) -> str:
    kind = section.get("kind", "hold") if isinstance(section, dict) else "hold"
    return kind if kind in ("decay", "zero") else "hold"  # others 'hold' refuses by name


FallbackFile = Annotated[
    Annotated[HoldFile, Tag("hold")]
    | Annotated[DecayFile, Tag("decay")]
    | Annotated[ZeroFile, Tag("zero")],
    Discriminator(_kind_of_fallback),
]
