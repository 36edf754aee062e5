"""A row of any table, checked as it is read."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tsd_casadi.database.checksum import checksum
from tsd_casadi.document import AnyDocument, Document
from tsd_casadi.exceptions import MalformedMessage


class Row(Document):
    """A row of a table; the fields are its columns but the checksum."""

    @classmethod
    def check(cls: type[AnyDocument], columns: Mapping[str, Any]) -> AnyDocument:
        """Check a row and its checksum.

        Args:
            columns: All columns by name.

        Raises:
            ValueError: If it is not what was written, or makes no sense.
        """
        content = without_checksum(columns)
        if columns["checksum"] != checksum(content):
            raise MalformedMessage("a row that does not fit its checksum", "it as it was written")
        return cls.model_validate(content)


def without_checksum(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Give all other columns of a row."""
    return {name: value for name, value in columns.items() if name != "checksum"}
