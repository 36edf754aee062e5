"""What the JSON messages of version 2 have in common."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from tsd_casadi.document import Document
from tsd_casadi.exceptions import MalformedMessage, UnsupportedVersion

VERSION = 2
# of a motion, empty where nobody said one
VersionText = Annotated[str, Field(pattern=r"^[A-Za-z0-9_.:+-]*$", max_length=100)]
Instance = Annotated[int, Field(ge=0)]


class Message(Document):
    """A document with its name and version in the field 'format'."""

    @classmethod
    def check_version(cls, document: dict[str, Any]) -> None:
        """Refuse a message of another version, and one without a version, as 1 was.

        Raises:
            UnsupportedVersion: If it is of another version.
            MalformedMessage: If it is another message.
        """
        expected = str(cls.model_fields["format"].default)
        given = document.get("format")
        if given == expected:
            return
        name = expected.rpartition("/")[0]
        remedy = (
            f"\"format\": \"{expected}\", with 'motion' in place of 'task' and the other fields "
            "of docs/wire.md; use the same version of client and service"
        )
        if given is None:
            raise UnsupportedVersion(f"{name} without a format, as in version 1", remedy)
        if isinstance(given, str) and given.startswith(f"{name}/"):
            raise UnsupportedVersion(f"a message {given[:100]}", remedy)
        raise MalformedMessage(f"format {str(given)[:100]!r}", f"'{expected}'")
