"""The body of an error reply."""

from __future__ import annotations

from tsd_casadi.document import Document
from tsd_casadi.exceptions import ServiceFailed, TsdError, class_of


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
        """Describe an error."""
        # a path may hold bytes that are no text
        message = str(error).encode(errors="replace").decode()
        return cls(code=error.code, message=message)

    def error(self) -> TsdError:
        """Make the error of the same class that the library raises.

        Returns:
            An error whose ``str`` is the message. Its attributes with data are
            None; a ``ServiceFailed`` if no class here has the code.
        """
        kind = class_of(self.code)
        if kind is None:
            return ServiceFailed(self.code, self.message)
        return kind.of_message(self.message)
