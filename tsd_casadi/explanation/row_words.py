"""The names of rows in the words of robotics."""

from __future__ import annotations

from dataclasses import dataclass

# what a row of one joint limits, with its unit
OF_JOINTS = {
    "joint_acceleration": ("acceleration", "rad/s^2"),
    "joint_torque": ("torque", "N m"),
}
# what a row of one contact limits
OF_CONTACTS = {
    "center_of_pressure": ("centre of pressure inside the sole's edge", "N m"),
    "friction": ("friction towards", "N"),
    "normal_torque": ("torsional friction about", "N m"),
    "unilateral_force": ("normal force", "N"),
}
# what an equality keeps
OF_EQUALITIES = {"acceleration": "no acceleration along"}


@dataclass(frozen=True)
class RowWords:
    """What a row is about.

    Attributes:
        where: Name of a joint or contact; empty for what is neither.
        what: Which of its limits.
        unit: Of the row's bound and violation; empty where only its name is known.
    """

    where: str
    what: str
    unit: str


def describe_row(name: str) -> RowWords:
    """Put a row's name into words, such as 'left_foot.friction.+x'.

    A row of a kind that has no words here keeps its name.
    """
    kind, _, joint = name.partition(".")
    if kind in OF_JOINTS:
        return RowWords(joint, *OF_JOINTS[kind])
    contact, _, rest = name.partition(".")
    limit, _, face = rest.partition(".")
    if limit in OF_CONTACTS:
        what, unit = OF_CONTACTS[limit]
        return RowWords(contact, f"{what} {face}".rstrip(), unit)
    if limit in OF_EQUALITIES:
        return RowWords(contact, f"{OF_EQUALITIES[limit]} {face}", "")
    return RowWords("", name, "")
