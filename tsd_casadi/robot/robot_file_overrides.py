"""The sections of a robot file that correct or complete its description."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from tsd_casadi.robot.robot_file_sections import Finite, NonNegative, Positive, Section, Vector3

# a joint's name, or a regular expression that matches whole names
Pattern = Annotated[str, Field(min_length=1)]


class LinkFile(Section):
    """Mass and inertia of a link, instead of the description's.

    What is left out stays as it is there.

    Attributes:
        mass: [kg].
        com: Centre of mass in the link's frame [m].
        inertia: (xx, yy, zz, xy, xz, yz) about the centre of mass, axes of the link
            [kg m^2].
    """

    mass: NonNegative | None = None
    com: Vector3 | None = None
    inertia: tuple[Finite, Finite, Finite, Finite, Finite, Finite] | None = None


class TorqueSpeedFile(Section):
    """What a motor has left as it turns faster, at the joint: a line.

    Attributes:
        stall_torque: At rest [N m]; where it is above the torque limit that one counts.
        no_load_speed: At which nothing is left [rad/s].
    """

    stall_torque: Positive
    no_load_speed: Positive


class OverridesFile(Section):
    """What is changed of the description, whose file stays untouched.

    Joints are named, or matched as a whole by a regular expression; where several
    match, the last counts.

    Attributes:
        locked: Joints that do not move, each with its angle [rad].
        effort: Torque limits [N m].
        torque_speed: Lines from stall torque to no-load speed.
        velocity: Velocity limits [rad/s].
        position: Joint limits (low, high) [rad].
        acceleration: Acceleration limits [rad/s^2], instead of ``limits``.
        links: Masses and inertias by name of the link.
        base_orientation: Roll, pitch and yaw of the base link where the robot
            stands upright [rad].
    """

    locked: dict[Pattern, Finite] = Field(default_factory=dict)
    effort: dict[Pattern, Positive] = Field(default_factory=dict)
    torque_speed: dict[Pattern, TorqueSpeedFile] = Field(default_factory=dict)
    velocity: dict[Pattern, Positive] = Field(default_factory=dict)
    position: dict[Pattern, tuple[Finite, Finite]] = Field(default_factory=dict)
    acceleration: dict[Pattern, Positive] = Field(default_factory=dict)
    links: dict[str, LinkFile] = Field(default_factory=dict)
    base_orientation: Vector3 = (0.0, 0.0, 0.0)
