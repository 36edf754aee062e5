"""The body of an error reply."""

from __future__ import annotations

from tsd_casadi.document import Document
from tsd_casadi.exceptions import TsdError


class ErrorMessage(Document):
    """Body of an error reply.

    Attributes:
        code: Short machine-readable name.
        message: What was wrong, what was expected, what to do.
    """

    code: str
    message: str

    @classmethod
    def of(cls, error: TsdError) -> ErrorMessage:
        """The message of an error."""
        return cls(code=error.code, message=str(error))
