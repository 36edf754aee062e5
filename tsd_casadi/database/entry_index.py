"""Finds entries by what they are for, without reading them."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry_key import EntryKey

Parameters = tuple[tuple[str, float], ...]
# parameters are rounded to millionths, see ``EntryKey``
_MILLION = 1_000_000
_COLUMNS = (
    "entry, event, robot, motion, version, axes, place, body, formulation, correction, "
    "sequence, updated"
)
_NEWEST_FIRST = "ORDER BY sequence DESC, updated DESC, entry DESC"
_OF_ANY = "(? IS NULL OR robot = ?) AND (? IS NULL OR motion = ?)"
_OF_GROUP = (
    "robot = ? AND motion = ? AND version = ? AND body = ? AND formulation = ? AND correction = ?"
)


@dataclass(frozen=True)
class IndexedEntry:
    """An entry as the index knows it.

    Attributes:
        identifier: Its number.
        event: The newest event of it: what is read of it stays right until there is another.
        key: What it is for.
        sequence: Counts the recordings; 0 for what was not recorded here.
        updated: When it was changed last, ISO 8601, UTC.
    """

    identifier: int
    event: int
    key: EntryKey
    sequence: int
    updated: str

    @property
    def age(self) -> tuple[int, str, int]:
        """By which the newest is found: the largest."""
        return self.sequence, self.updated, self.identifier


@dataclass(frozen=True)
class Group:
    """The entries of a motion on one robot that have version and context in common.

    Attributes:
        version: Of the motion.
        context: Of all of them.
        entries: Their number.
        newest: The age of the newest, see ``IndexedEntry``.
    """

    version: str
    context: Context
    entries: int
    newest: tuple[int, str, int]


class EntryIndex:
    """Reads the derived tables of a file; the caller begins and ends the transactions."""

    def __init__(self, file: DatabaseFile) -> None:
        """Take an open file."""
        self._file = file

    def robots(self, motion: str) -> list[str]:
        """List the robots with entries of a motion."""
        rows = self._file.execute(
            "SELECT DISTINCT robot FROM entry_count WHERE motion = ? AND entries > 0 "
            "ORDER BY robot",
            (motion,),
        )
        return [row[0] for row in rows]

    def groups(self, robot: str, motion: str) -> list[Group]:
        """List what there is of a motion on one robot."""
        rows = self._file.execute(
            "SELECT c.version, c.body, c.formulation, c.correction, c.entries, "
            "s.sequence, s.updated, s.entry FROM entry_count AS c JOIN entry_state AS s "
            "ON s.entry = (SELECT entry FROM entry_state WHERE robot = c.robot "
            "AND motion = c.motion AND version = c.version AND body = c.body "
            f"AND formulation = c.formulation AND correction = c.correction {_NEWEST_FIRST} "
            "LIMIT 1) WHERE c.robot = ? AND c.motion = ? AND c.entries > 0",
            (robot, motion),
        )
        return [Group(row[0], Context(*row[1:4]), row[4], row[5:8]) for row in rows]

    def at(self, robot: str, motion: str, parameters: Parameters) -> list[IndexedEntry]:
        """Find the entries of a motion with exactly these parameters, of any context."""
        return self._find(
            "robot = ? AND motion = ? AND place = ?", (robot, motion, place(parameters))
        )

    def exact(self, key: EntryKey) -> IndexedEntry | None:
        """Find the entry of a key."""
        found = self.at(key.robot, key.motion, key.parameters)
        return next((each for each in found if each.key == key), None)

    def known_order(self, key: EntryKey) -> tuple[str, ...]:
        """Order a key's axes as the entries that it is compared with have them.

        Returns:
            Its own order where that is known, or where none is.
        """
        values = (key.robot, key.motion, key.version, *vars(key.context).values())
        rows = self._file.execute(
            f"SELECT DISTINCT axes FROM entry_state WHERE {_OF_GROUP}", values
        )
        known = [_axes(axes) for (axes,) in rows]
        same = [axes for axes in known if set(axes) == set(key.axes)]
        return key.axes if key.axes in same else min(same, default=key.axes)

    def of_group(
        self, robot: str, motion: str, version: str, context: Context, most: int
    ) -> list[IndexedEntry]:
        """Find the newest entries of a group, in the order of their identifiers.

        Args:
            most: How many of them.
        """
        values = (robot, motion, version, context.body, context.formulation, context.correction)
        found = self._find(f"{_OF_GROUP} {_NEWEST_FIRST} LIMIT ?", (*values, most))
        return sorted(found, key=lambda each: each.identifier)

    def declared(self, robot: str, motion: str, version: str) -> Iterable[int]:
        """Find the events that said something of a motion, that of the newest entry first."""
        rows = self._file.read(
            "SELECT declared FROM entry_state WHERE robot = ? AND motion = ? AND version = ? "
            f"AND declared IS NOT NULL {_NEWEST_FIRST}",
            (robot, motion, version),
        )
        return (row[0] for row in rows)

    def count(self, robot: str | None = None, motion: str | None = None) -> int:
        """Count the entries, of a robot and a motion or of all."""
        rows = self._file.execute(
            f"SELECT coalesce(sum(entries), 0) FROM entry_count WHERE {_OF_ANY}",
            (robot, robot, motion, motion),
        )
        return int(rows[0][0])

    def newest(self, robot: str | None, motion: str | None, most: int) -> list[int]:
        """Find the numbers of the entries that were recorded last, in their order.

        Args:
            most: How many of them.
        """
        rows = self._file.execute(
            f"SELECT entry FROM entry_state WHERE {_OF_ANY} {_NEWEST_FIRST} LIMIT ?",
            (robot, robot, motion, motion, most),
        )
        return sorted(row[0] for row in rows)

    def above(self, robot: str | None, motion: str | None, number: int, most: int) -> list[int]:
        """Find the numbers of the entries that come after one, in their order; as above."""
        rows = self._file.execute(
            f"SELECT entry FROM entry_state WHERE {_OF_ANY} AND entry > ? ORDER BY entry LIMIT ?",
            (robot, robot, motion, motion, number, most),
        )
        return [row[0] for row in rows]

    def count_above(self, robot: str | None, motion: str | None, number: int) -> int:
        """Count the entries that come after one."""
        rows = self._file.execute(
            f"SELECT count(*) FROM entry_state WHERE {_OF_ANY} AND entry > ?",
            (robot, robot, motion, motion, number),
        )
        return int(rows[0][0])

    def _find(self, condition: str, values: tuple[Any, ...]) -> list[IndexedEntry]:
        rows = self._file.execute(f"SELECT {_COLUMNS} FROM entry_state WHERE {condition}", values)
        return [_indexed(row) for row in rows]


def place(parameters: Parameters) -> str:
    """Write parameters as the index does: the same text for the same numbers.

    Args:
        parameters: As in a key.
    """
    return ";".join(f"{name}={round(value * _MILLION)}" for name, value in parameters)


def _indexed(row: tuple[Any, ...]) -> IndexedEntry:
    number, event, robot, motion, version, axes, where, *context, sequence, updated = row
    return IndexedEntry(
        number,
        event,
        EntryKey(robot, motion, version, _axes(axes), _parameters(where), Context(*context)),
        sequence,
        updated,
    )


def _axes(text: str) -> tuple[str, ...]:
    try:
        return tuple(json.loads(text))
    except (ValueError, TypeError):  # damaged; reading the entry says so
        return ()


def _parameters(text: str | None) -> Parameters:
    pairs = (pair.partition("=") for pair in (text or "").split(";") if pair)
    return tuple((name, int(value) / _MILLION) for name, _, value in pairs)
