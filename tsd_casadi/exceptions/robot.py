"""The robot's files cannot be used."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tsd_casadi.exceptions.base import TsdError
from tsd_casadi.exceptions.did_you_mean import did_you_mean


class RobotError(TsdError):
    """What is wrong with a robot's description."""


class RobotFileError(RobotError):
    """A robot file, or a file it names, cannot be used.

    Attributes:
        path: The file.
        field: Dotted path of the offending field, empty for the whole file.
        expected: What was expected there.
    """

    code = "robot_file"
    path: Path | None = None
    field: str | None = None
    expected: str | None = None

    def __init__(self, path: Path, field: str, found: str, expected: str) -> None:
        """Create the error for one field of one file."""
        self.path = path
        self.field = field
        self.expected = expected
        where = f"field '{field}'" if field else "file"
        super().__init__(f"{path}: {where}: {found}; expected {expected}")


class UnknownRobot(RobotError):
    """No shipped robot has that name and no file is there.

    Attributes:
        name: What was asked for.
        known: Names of the shipped robots.
    """

    code = "unknown_robot"
    name: str | None = None
    known: list[str] | None = None

    def __init__(self, name: str, known: Sequence[str]) -> None:
        """Create the error for one name."""
        self.name = name
        self.known = list(known)
        super().__init__(
            f"no robot '{name}'; expected one of {', '.join(known)}, "
            f"or the path of a robot file (.yaml){did_you_mean(name, known)}"
        )


class ParityError(RobotError):
    """Two descriptions of one robot disagree.

    Attributes:
        quantity: What was compared.
        difference: Largest absolute difference.
    """

    code = "parity"
    quantity: str | None = None
    difference: float | None = None

    def __init__(self, robot: str, quantity: str, difference: float, allowed: float) -> None:
        """Create the error for one quantity."""
        self.quantity = quantity
        self.difference = difference
        super().__init__(
            f"robot '{robot}': {quantity} from the URDF and from the MuJoCo scene differ "
            f"by {difference:.3g}, expected at most {allowed:.0e}; compare masses, "
            "inertias, joint axes and placements in the two files"
        )
