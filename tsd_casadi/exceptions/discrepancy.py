"""One difference between two descriptions of a robot."""

from __future__ import annotations

from typing import NamedTuple


class Discrepancy(NamedTuple):
    """One way in which a scene is not the robot described.

    Attributes:
        element: Body, joint, contact or option by name, for instance 'joint left_knee'.
        quantity: What was compared there.
        found: What it is in the scene, with its unit.
        expected: What it is in the description, with its unit.
        remedy: What to change.
    """

    element: str
    quantity: str
    found: str
    expected: str
    remedy: str

    def __str__(self) -> str:
        """Write it in one line."""
        return (
            f"{self.element}: {self.quantity} is {self.found} in the scene, expected "
            f"{self.expected}; {self.remedy}"
        )
