"""The robot's files cannot be used."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tsd_casadi.exceptions.base import TsdError
from tsd_casadi.exceptions.did_you_mean import did_you_mean
from tsd_casadi.exceptions.discrepancy import Discrepancy


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
    """A robot's description and its scene disagree.

    Attributes:
        path: The scene.
        discrepancies: Everything that differs.
    """

    code = "parity"
    path: Path | None = None
    discrepancies: list[Discrepancy] | None = None

    def __init__(self, robot: str, path: Path, discrepancies: Sequence[Discrepancy]) -> None:
        """Create the error for one scene."""
        self.path = path
        self.discrepancies = list(discrepancies)
        count = len(self.discrepancies)
        ways = "one way" if count == 1 else f"{count} ways"
        lines = "".join(f"\n  {discrepancy}" for discrepancy in self.discrepancies)
        super().__init__(f"{path}: this scene is not the robot '{robot}' in {ways}:{lines}")
