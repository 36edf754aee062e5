"""What one robot learned, in a file for another machine: a line of JSON for each entry."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from tsd_casadi.database.checksum import checksum
from tsd_casadi.database.columns import entry_columns, event_columns, iteration_columns
from tsd_casadi.database.iteration_rows import IterationRow
from tsd_casadi.database.rows import EntryRow, EventRow, build
from tsd_casadi.document import AnyDocument, Document, Name
from tsd_casadi.exceptions import InvalidValue, MalformedMessage
from tsd_casadi.learning.entry import Entry
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.version import __version__
from tsd_casadi.whole_file import write_whole

LARGEST_LINE = 50_000_000
# columns that hold JSON, plain in the file
_JSON = {
    "axes",
    "parameters",
    "basis",
    "declaration",
    "circumstances",
    "weights",
    "uncertainty",
    "errors",
    "feedback",
    "error_weights",
    "reference_weights",
}


@dataclass(frozen=True)
class Imported:
    """What came of a file.

    Attributes:
        added: Entries that are new here.
        skipped: Entries that were here already; they stay as they were.
    """

    added: int
    skipped: int


class HeaderLine(Document):
    """The first line of a file.

    Attributes:
        format: Name and version of the file.
        version: Of the software that wrote it.
        entries: Number of lines that follow.
    """

    format: Literal["tsd.entries/1"] = "tsd.entries/1"
    version: str
    entries: Annotated[int, Field(ge=0)]


class EntryLine(Document):
    """An entry as it is: columns of its rows, JSON columns as plain data.

    Attributes:
        entry: What it is for.
        event: How it is since its newest event.
        iterations: All of them.
        checksum: Of the others.
    """

    entry: dict[str, Any]
    event: dict[str, Any]
    iterations: Annotated[list[dict[str, Any]], Field(min_length=1)]
    checksum: str


class _Names(Document):
    robot: Annotated[str, Field(pattern=r"^[^/*$#?@\x00-\x1f]{1,100}$")]
    motion: Name
    axes: Annotated[tuple[Name, ...], Field(max_length=50)]


def write_entries(entries: Sequence[Entry], path: str | Path) -> None:
    """Write entries to a file, whole or not at all.

    Raises:
        InvalidValue: If it cannot be written.
    """
    with write_whole(path) as file:
        header = HeaderLine(version=__version__, entries=len(entries))
        file.write(header.encode() + b"\n")
        for entry in entries:
            content: dict[str, Any] = {
                "entry": _plain(entry_columns(entry)),
                "event": _plain(event_columns(entry, 0, "imported")),
                "iterations": [
                    _plain(iteration_columns(entry.identifier, 0, each))
                    for each in entry.iterations
                ],
            }
            line = EntryLine(**content, checksum=checksum(content))
            file.write(line.encode() + b"\n")


def read_entries(path: str | Path) -> list[Entry]:
    """Read all entries of a file, checked.

    Returns:
        The entries, without identifiers.

    Raises:
        InvalidValue: If it cannot be read, is incomplete or damaged.
    """
    try:
        with Path(path).open("rb") as file:
            lines = iter(lambda: file.readline(LARGEST_LINE), b"")
            header = _decode(HeaderLine, next(lines, b""), path, 1)
            entries = list(_entries(lines, path))
    except OSError as error:
        reason = error.strerror or str(error)
        raise InvalidValue("import", f"'{path}' ({reason})", "a readable file") from error
    if len(entries) != header.entries:
        raise InvalidValue(
            f"'{path}'", f"a file of {len(entries)} entries", f"the {header.entries} that it says"
        )
    return entries


def _entries(lines: Iterator[bytes], path: str | Path) -> Iterator[Entry]:
    for number, text in enumerate(lines, start=2):
        line = _decode(EntryLine, text, path, number)
        content = {"entry": line.entry, "event": line.event, "iterations": line.iterations}
        try:
            if line.checksum != checksum(content):
                raise MalformedMessage("a line that does not fit its checksum", "it as written")
            row = EntryRow.model_validate(_columns({**line.entry, "id": 1}))
            _Names(robot=row.robot, motion=row.motion, axes=row.axes)
            entry = build(
                row,
                [EventRow.model_validate(_columns(line.event))],
                [IterationRow.model_validate(_columns(each)) for each in line.iterations],
            )
            declaration = entry.declaration or Declaration.unknown(row.motion, row.version)
            declaration.complete(row.parameters)
        except (ValueError, TypeError) as error:  # of pydantic, or one of ours
            raise _refused(path, number, error) from error
        entry.identifier = entry.sequence = 0
        yield entry


def _decode(kind: type[AnyDocument], text: bytes, path: str | Path, number: int) -> AnyDocument:
    try:
        return kind.decode(text)
    except MalformedMessage as error:
        raise _refused(path, number, error) from error


def _refused(path: str | Path, number: int, error: Exception) -> InvalidValue:
    reason = str(error)
    if isinstance(error, ValidationError):
        first = error.errors()[0]
        reason = f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
    return InvalidValue(
        f"'{path}'",
        f"damaged or no file of entries, line {number} ({' '.join(reason.split())})",
        "a file of 'tsd database export'; nothing was imported",
    )


def _plain(columns: dict[str, Any]) -> dict[str, Any]:
    return {
        name: json.loads(value) if name in _JSON and value is not None else value
        for name, value in columns.items()
    }


def _columns(plain: dict[str, Any]) -> dict[str, Any]:
    return {
        name: json.dumps(value) if name in _JSON and value is not None else value
        for name, value in plain.items()
    }
