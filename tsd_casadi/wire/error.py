"""The body of an error reply."""

from __future__ import annotations

import math
from pathlib import PurePath
from typing import Any, Literal, get_type_hints

from pydantic import TypeAdapter, ValidationError

from tsd_casadi.document import Document
from tsd_casadi.exceptions import ServiceFailed, TsdError, UnsupportedVersion, class_of

# of text in the data, and of entries of a list
LARGEST = 1000


class ErrorMessage(Document):
    """Body of an error reply.

    Attributes:
        format: Name and version of this message.
        code: Short machine-readable name.
        message: What was wrong, what was expected, what to do.
        data: Attributes of the error by name, plain data, if it has any.
    """

    format: Literal["tsd.error/2"] | None = None
    code: str
    message: str
    data: dict[str, Any] | None = None

    @classmethod
    def of(cls, error: TsdError) -> ErrorMessage:
        """Describe an error."""
        # a path may hold bytes that are no text
        message = _text(str(error))
        if error.code == UnsupportedVersion.code:
            # whoever speaks version 1 has to be able to read it
            return cls(code=error.code, message=message)
        data = {name: _plain(value) for name, value in vars(error).items() if name in _data(error)}
        return cls(format="tsd.error/2", code=error.code, message=message, data=data or None)

    def encode(self) -> bytes:
        """Write the message as UTF-8 JSON, without what is empty."""
        return self.model_dump_json(exclude_none=True).encode()

    def error(self) -> TsdError:
        """Make the error of the same class that the library raises.

        Returns:
            An error whose ``str`` is the message, with its data where that came
            and makes sense, None otherwise; a ``ServiceFailed`` if no class here
            has the code.
        """
        kind = class_of(self.code)
        if kind is None:
            return ServiceFailed(self.code, self.message)
        error = kind.of_message(self.message)
        hints = _data(error)
        for name, value in (self.data or {}).items():
            if name in hints:
                try:
                    setattr(error, name, TypeAdapter(hints[name]).validate_python(value))
                except ValidationError:
                    continue  # of another version of this software: unknown here
        return error


def _data(error: TsdError) -> dict[str, Any]:
    """Types of the attributes with data of a class of errors, by name."""
    return {
        name: hint
        for name, hint in get_type_hints(type(error)).items()
        if not name.startswith("_") and name != "code"
    }


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value[:LARGEST]]
    if isinstance(value, str | PurePath):
        return _text(str(value))[:LARGEST]
    return _text(repr(value))[:LARGEST]


def _text(text: str) -> str:
    return text.encode(errors="replace").decode()
