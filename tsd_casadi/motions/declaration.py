"""What is said of a motion where its code is not: in messages and in the database."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.exceptions.did_you_mean import did_you_mean
from tsd_casadi.motions.parameter import LARGEST, RESERVED, Parameter


@dataclass(frozen=True)
class Declaration:
    """A motion's name, version and parameters; data, never code.

    Attributes:
        motion: Name of the motion.
        version: Another one means another motion: what was learned of the one
            says nothing about the other.
        parameters: In the order of the class.
    """

    motion: str
    version: str
    parameters: tuple[Parameter, ...]

    def unit_of(self, name: str) -> str:
        """Tell the unit of a parameter; empty if it is none of this motion."""
        return next((item.unit for item in self.parameters if item.name == name), "")

    @classmethod
    def unknown(cls, motion: str, version: str = "") -> Declaration:
        """Stand for what nobody said: any parameter, without unit, default or range."""
        return cls(motion, version, ())

    def complete(self, given: Mapping[str, float]) -> dict[str, float]:
        """Check the parameters, and fill in those with a default.

        Args:
            given: By name, SI units.

        Raises:
            InvalidValue: If one is missing, unknown, not finite or out of the
                range that makes sense on any robot.
        """
        known = {item.name: item for item in self.parameters}
        if not known:
            known = {name: Parameter(name, "") for name in given}
        for name, value in given.items():
            if name in RESERVED:
                raise InvalidValue(f"parameter '{name}'", f"{value:g}", "another name")
            if name not in known:
                expected = self._listed() + did_you_mean(name, known)
                raise InvalidValue(f"parameter of the {self.motion}", f"'{name}'", expected)
            item = known[name]
            if not abs(value) < LARGEST:
                unit = f" in {item.unit}" if item.unit else ""
                raise InvalidValue(name, value, f"a number{unit} below {LARGEST:g}")
            if not item.low <= value <= item.high:
                raise InvalidValue(name, f"{value:g}", item.range_text())
        defaults = {item.name: item.default for item in self.parameters if item.default is not None}
        complete = {**defaults, **given}
        missing = [name for name in known if name not in complete]
        if missing:
            raise InvalidValue(
                f"the {self.motion}",
                f"without {' and without '.join(missing)}",
                f"all of {self._listed()}",
            )
        return {name: complete[name] for name in known}

    def _listed(self) -> str:
        return "; ".join(item.describe() for item in self.parameters)
