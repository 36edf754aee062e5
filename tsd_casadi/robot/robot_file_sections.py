"""The sections of a robot file: what may stand in each, with units."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

# strict: YAML's yes and no are not numbers
Positive = Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Vector3 = tuple[Finite, Finite, Finite]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]

COM_AXES = ("x", "y", "z")
FRAME_AXES = ("x", "y", "z", "rx", "ry", "rz")
ROTATIONS = FRAME_AXES[3:]


class Section(BaseModel):
    """A part of the robot file; unknown fields are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class OffsetFile(Section):
    """Where a frame is on a link that has none there.

    Attributes:
        xyz: Origin in the link's frame [m].
        rpy: Roll, pitch and yaw about the link's fixed axes, as in a URDF [rad].
    """

    xyz: Vector3 = (0.0, 0.0, 0.0)
    rpy: Vector3 = (0.0, 0.0, 0.0)


class SoleFile(Section):
    """A flat foot on the ground.

    Attributes:
        type: Always 'sole', and so where it is left out.
        name: Name of the contact.
        frame: Link or frame of the description.
        offset: From that to the sole, z up out of the ground; none if the frame is there.
        x: Extent of the sole along x in the sole's frame, (low, high) [m].
        y: Extent of the sole along y in the sole's frame, (low, high) [m].
        friction: Coulomb coefficient that the controller counts on.
        torsional_friction: Bound of |normal torque| / normal force [m].
        minimum_force: Least normal force while in contact [N].
    """

    type: Literal["sole"] = "sole"
    name: Name
    frame: str
    offset: OffsetFile | None = None
    x: tuple[Finite, Finite]
    y: tuple[Finite, Finite]
    friction: Positive
    torsional_friction: Positive
    minimum_force: NonNegative


class PointFile(Section):
    """A foot that touches the ground in a point and carries no moment.

    It is a ball at the end of a leg: its link turns while the leg moves. So only
    the frame's origin counts, which has to be on the ground at home; the force is
    in axes parallel to the world's, its normal the world's z.

    Attributes:
        type: Always 'point'.
        name: Name of the contact.
        frame: Link or frame of the description.
        offset: From that to the point; none if the frame is there.
        friction: Coulomb coefficient that the controller counts on.
        minimum_force: Least normal force while in contact [N].
    """

    type: Literal["point"]
    name: Name
    frame: str
    offset: OffsetFile | None = None
    friction: Positive
    minimum_force: NonNegative


Contact = SoleFile | PointFile


def _kind_of_contact(contact: object) -> str:
    kind = contact.get("type", "sole") if isinstance(contact, dict) else "sole"
    return kind if kind == "point" else "sole"  # what is neither, 'sole' refuses by name


AnyContact = Annotated[
    Annotated[SoleFile, Tag("sole")] | Annotated[PointFile, Tag("point")],
    Discriminator(_kind_of_contact),
]


class PostureFile(Section):
    """Posture in the null space of tasks and contacts.

    Attributes:
        P: Stiffness P_q [1/s^2].
        D: Damping D_q [1/s].
        W: Weight W_q [(rad/s^2)^-2].
    """

    P: NonNegative
    D: NonNegative
    W: NonNegative


class RegularizationFile(Section):
    """Weights that make the optimum unique.

    Attributes:
        force: Weight of contact forces about lambda_des [1/N^2].
        moment: Weight of contact moments about lambda_des [1/(N m)^2].
        acceleration: Weight of all accelerations about zero.
    """

    force: Positive
    moment: Positive
    acceleration: Positive


class LimitsFile(Section):
    """Limits beyond those of the URDF.

    Attributes:
        acceleration: Bound of |joint acceleration| [rad/s^2].
    """

    acceleration: Positive


class SafeTorqueFile(Section):
    """What a failed tick answers with.

    Attributes:
        D: Joint damping [N m s/rad].
    """

    D: NonNegative


class HardwareFile(Section):
    """What a real robot has and a rigid-body simulation has not.

    Every effect is off in a simulation unless it is asked for by name.

    Attributes:
        armature: Rotor inertia as the joint feels it [kg m^2].
        viscous_friction: [N m s/rad].
        coulomb_friction: [N m].
        torque_lag: Time constant of the torque's first-order lag [s].
        torque_delay: From command to torque, before the lag [s].
        encoder_resolution: Step of the joint encoders [rad].
        encoder_noise: Standard deviation, white [rad].
        velocity_filter: Time constant of the low pass behind the
            differencing of joint positions [s].
    """

    armature: NonNegative
    viscous_friction: NonNegative
    coulomb_friction: NonNegative
    torque_lag: NonNegative
    torque_delay: NonNegative
    encoder_resolution: NonNegative
    encoder_noise: NonNegative
    velocity_filter: NonNegative


class MotionFile(BaseModel):
    """What this robot can do of one motion: ranges of its parameters, by name.

    Attributes:
        task: Name of the task that carries it; the motion chooses one if left out.
    """

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, tuple[Finite, Finite]]

    task: Name | None = None

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """(low, high) by name of the parameter, SI units."""
        return dict(self.__pydantic_extra__)
