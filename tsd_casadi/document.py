"""What all JSON documents have in common: messages of the network and files."""

from __future__ import annotations

import json
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import from_json

from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.state import Matrix

Finite = Annotated[float, Field(allow_inf_nan=False, ge=-1e9, le=1e9)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.]*$", max_length=100)]
MOST_FIELDS = 50
AnyDocument = TypeVar("AnyDocument", bound="Document")


class Document(BaseModel):
    """A JSON document; unknown fields are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    def encode(self) -> bytes:
        """Write the message as UTF-8 JSON."""
        return self.model_dump_json().encode()

    @classmethod
    def check_version(cls, document: dict[str, Any]) -> None:
        """Refuse a document of another version, for kinds that have versions.

        Args:
            document: Its fields, nothing of them checked.
        """

    @classmethod
    def decode(cls: type[AnyDocument], payload: bytes) -> AnyDocument:
        """Read and check a message.

        Args:
            payload: UTF-8 JSON.

        Raises:
            MalformedMessage: If it is no JSON or a field is wrong.
            UnsupportedVersion: If it is of another version.
        """
        try:
            document = from_json(payload)
        except ValueError as error:
            raise MalformedMessage(f"{cls.__name__}: {error}", "a JSON object") from error
        # pydantic would list every unknown field, however many
        if not isinstance(document, dict) or len(document) > MOST_FIELDS:
            raise MalformedMessage(
                f"{cls.__name__}: {type(document).__name__} of {len(payload)} bytes",
                "a JSON object with its fields",
            )
        cls.check_version(document)
        try:
            message = cls.model_validate(document)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(map(str, first["loc"])) or "message"
            raise MalformedMessage(
                f"{cls.__name__}: {where}: {first['msg']}", "valid JSON of it"
            ) from error
        try:
            # NaN is no JSON, not even where any value may stand
            from_json(payload, allow_inf_nan=False)
        except ValueError as error:
            raise MalformedMessage(f"{cls.__name__}: {error}", "finite numbers") from error
        return message


def to_matrix(name: str, rows: list[list[float]], shape: tuple[int, int]) -> Matrix:
    """Make an array of rows, checked for its shape.

    Args:
        name: Of the field, for the error.
        shape: Number and length of the rows.

    Raises:
        MalformedMessage: If the shape is another one.
    """
    if len(rows) != shape[0] or any(len(row) != shape[1] for row in rows):
        raise MalformedMessage(f"{name} of another shape", f"{shape[0]} rows of {shape[1]} numbers")
    return np.array(rows, dtype=float)


def json_schema(kind: type[Document]) -> str:
    """Write the JSON schema of a class of messages, for the docs."""
    return json.dumps(kind.model_json_schema(), indent=2)
