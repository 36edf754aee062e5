"""What all errors have in common."""

from __future__ import annotations

from functools import cache
from typing import Any, Self, TypeVar

AnyError = TypeVar("AnyError", bound="TsdError")


class TsdError(Exception):
    """Base class of all errors raised on purpose.

    Attributes:
        code: Short machine-readable name, used in error replies.
    """

    code = "error"

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by attributes, since the constructors' arguments differ."""
        return _restore, (type(self), self.args, self.__dict__)

    @classmethod
    def of_message(cls, message: str) -> Self:
        """Make an error of this class of which nothing but its message is known.

        Args:
            message: What was wrong, what was expected, what to do.

        Returns:
            The error; attributes with data are None.
        """
        return _restore(cls, (message,), {})


def class_of(code: str) -> type[TsdError] | None:
    """Find the class whose errors have a code.

    Args:
        code: As in an error reply.

    Returns:
        The class, or None if no class here has that code.
    """
    return _classes().get(code)


def _restore(kind: type[AnyError], arguments: tuple[Any, ...], data: dict[str, Any]) -> AnyError:
    error = kind.__new__(kind)
    error.args = arguments
    error.__dict__.update(data)
    return error


@cache
def _classes() -> dict[str, type[TsdError]]:
    found: dict[str, type[TsdError]] = {}
    waiting: list[type[TsdError]] = [TsdError]
    for kind in waiting:
        waiting.extend(kind.__subclasses__())
        if "code" in vars(kind):  # the base class of a family has none of its own
            found[kind.code] = kind
    return found
