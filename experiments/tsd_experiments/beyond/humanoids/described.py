"""The humanoids with flat feet that example-robot-data describes, and their feet."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tsd_casadi.exceptions import UnknownRobot
from tsd_casadi.robot.description_path import find_package

PACKAGE = "example-robot-data"


@dataclass(frozen=True)
class Described:
    """A humanoid as its description has it.

    Attributes:
        name: For tables and the robot file.
        file: Its description, in the folder of robots of the package.
        feet: Links of the left and of the right foot, or frames on them.
        locks: Joints that are not to move: fingers and grippers.
    """

    name: str
    file: str
    feet: tuple[str, str]
    locks: tuple[str, ...] = ()

    @property
    def source(self) -> Path:
        """Where the description is.

        Raises:
            UnknownRobot: If the package is not installed.
        """
        folder = find_package(PACKAGE)
        if folder is None:
            raise UnknownRobot(f"{self.name} without 'pip install {PACKAGE}'", [])
        return folder / "robots" / self.file


G1_FEET = ("left_ankle_roll_link", "right_ankle_roll_link")
TALOS_FEET = ("left_sole_link", "right_sole_link")
SOLES = ("l_sole", "r_sole")
# simple_humanoid has no geometry, alex no legs, romeo_laas_small no mass in its hands
HUMANOIDS = (
    Described("g1", "g1_description/urdf/g1_29dof_rev_1_0.urdf", G1_FEET),
    Described(
        "g1_with_hands",
        "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf",
        G1_FEET,
        (".*_hand_.*",),
    ),
    Described("talos", "talos_data/robots/talos_full_v2.urdf", TALOS_FEET, ("gripper.*",)),
    Described("talos_box", "talos_data/robots/talos_full_v2_box.urdf", TALOS_FEET, ("gripper.*",)),
    Described("talos_reduced", "talos_data/robots/talos_reduced.urdf", TALOS_FEET),
    Described(
        "romeo", "romeo_description/urdf/romeo.urdf", SOLES, ("[LR](Hand|Finger.*|Thumb.*)",)
    ),
    Described("icub", "icub_description/robots/icub.urdf", SOLES),
    Described("icub_reduced", "icub_description/robots/icub_reduced.urdf", SOLES),
    Described("human", "human_description/robots/human.urdf", ("left_foot", "right_foot")),
    Described(
        "alexander",
        "alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf",
        ("LEFT_FOOT", "RIGHT_FOOT"),
    ),
)
