"""What was handed over does not make sense: numbers, names and messages."""

from __future__ import annotations

from collections.abc import Sequence

from tsd_casadi.exceptions.base import TsdError
from tsd_casadi.exceptions.did_you_mean import did_you_mean


class InvalidValue(TsdError, ValueError):
    """A number is outside its range or not a number.

    Attributes:
        field: Name of the quantity, with its index where it has one.
        value: What was given.
        expected: What was expected.
    """

    code = "invalid_value"
    field: str | None = None
    value: object = None
    expected: str | None = None

    def __init__(self, field: str, value: object, expected: str) -> None:
        """Create the error for one value."""
        self.field = field
        self.value = value
        self.expected = expected
        super().__init__(f"{field} is {value}, expected {expected}")


class UnknownField(TsdError, KeyError):
    """A vector has no field of that name.

    Attributes:
        name: What was asked for.
        known: The fields there are.
    """

    code = "unknown_field"
    name: str | None = None
    known: list[str] | None = None

    def __init__(self, name: str, known: Sequence[str]) -> None:
        """Create the error for one name."""
        self.name = name
        self.known = list(known)
        close = did_you_mean(name, known)
        super().__init__(f"no field '{name}'{close}; there are {', '.join(known)}")

    def __str__(self) -> str:
        """Message without the quotes that KeyError adds."""
        return str(self.args[0])


class MalformedMessage(TsdError, ValueError):
    """Bytes or JSON from the network cannot be read.

    Attributes:
        expected: What was expected.
    """

    code = "malformed"
    expected: str | None = None

    def __init__(self, found: str, expected: str) -> None:
        """Create the error for one message."""
        self.expected = expected
        super().__init__(f"{found}; expected {expected}")


class UnsupportedVersion(MalformedMessage):
    """A message speaks another version of the protocol."""

    code = "version"


class LayoutMismatch(MalformedMessage):
    """A message was packed for another formulation or robot."""

    code = "layout"
