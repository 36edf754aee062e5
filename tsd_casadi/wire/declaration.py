"""What is said of a motion, on the network; data, never code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from functools import lru_cache
from typing import Annotated

from pydantic import Field

from tsd_casadi.document import Document, Finite, Name
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.motions.parameter import LARGEST, Parameter
from tsd_casadi.wire.message import VersionText


class ParameterMessage(Document):
    """One parameter of a motion.

    Attributes:
        name: Its name.
        unit: SI unit.
        meaning: What it is, a few words.
        default: What it is where nothing is said; null if it has to be said.
        low: Smallest value that makes sense on any robot.
        high: Largest value that makes sense on any robot.
        extent: Whether it says how far the motion goes.
        place: Whether it says where the middle of the motion is.
        usual: What a command takes where nothing is said and there is no default.
    """

    name: Name
    unit: Annotated[str, Field(max_length=20)]
    meaning: Annotated[str, Field(max_length=200)] = ""
    default: Finite | None = None
    low: Finite = -LARGEST
    high: Finite = LARGEST
    extent: bool = False
    place: bool = False
    usual: Finite | None = None


class DeclarationMessage(Document):
    """What is said of a motion.

    Attributes:
        motion: Name of the motion.
        version: Of the motion; another one means another motion.
        parameters: In its order.
    """

    motion: Name
    version: VersionText
    parameters: Annotated[list[ParameterMessage], Field(max_length=50)]

    @classmethod
    def of(cls, declaration: Declaration) -> DeclarationMessage:
        """Describe a declaration."""
        return _described(declaration)

    def declaration(self) -> Declaration:
        """Make the declaration.

        Raises:
            MalformedMessage: If a parameter is there twice or its range is empty.
        """
        names = [item.name for item in self.parameters]
        for item in self.parameters:
            if names.count(item.name) > 1:
                raise MalformedMessage(f"parameter {item.name} twice", "each parameter once")
            if item.low > item.high:
                raise MalformedMessage(
                    f"parameter {item.name} from {item.low:g} to {item.high:g}", "the low one first"
                )
        parameters = tuple(Parameter(**item.model_dump()) for item in self.parameters)
        return Declaration(self.motion, self.version, parameters)


@lru_cache(100)
def _described(declaration: Declaration) -> DeclarationMessage:
    # every answer about a motion has the same, and making it takes as long as looking it up
    return DeclarationMessage(
        motion=declaration.motion,
        version=declaration.version,
        parameters=[ParameterMessage(**asdict(item)) for item in declaration.parameters],
    )


class QuantityMessage(Document):
    """A number with its unit; empty if nobody said one."""

    value: Finite
    unit: Annotated[str, Field(max_length=20)]


def quantities(
    declaration: Declaration, parameters: Mapping[str, float]
) -> dict[str, QuantityMessage]:
    """Describe parameters of a motion."""
    return {
        name: QuantityMessage(value=value, unit=declaration.unit_of(name))
        for name, value in parameters.items()
    }


def plain_parameters(
    declaration: Declaration, parameters: Mapping[str, QuantityMessage]
) -> dict[str, float]:
    """Check the units of a motion's parameters and drop them.

    Raises:
        MalformedMessage: If a unit is not the parameter's.
    """
    for name, quantity in parameters.items():
        if declaration.parameters and quantity.unit != declaration.unit_of(name):
            raise MalformedMessage(
                f"{name} of a {declaration.motion} in '{quantity.unit}'",
                f"'{declaration.unit_of(name)}'",
            )
    return {name: quantity.value for name, quantity in parameters.items()}
