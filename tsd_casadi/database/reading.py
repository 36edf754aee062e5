"""Questions to a database file, which nobody who writes keeps waiting."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Self

from tsd_casadi.database.answering import Answering
from tsd_casadi.database.answers import Answers
from tsd_casadi.database.damaged_entry import DamagedEntry
from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.database.database_state import DatabaseState
from tsd_casadi.database.entry_index import EntryIndex
from tsd_casadi.database.entry_rows import EntryRows
from tsd_casadi.database.kept_entries import KeptEntries
from tsd_casadi.database.outlines import Outlines
from tsd_casadi.database.schema import SCHEMA_VERSION
from tsd_casadi.exceptions import EntryNotFound, InvalidValue
from tsd_casadi.generalization.entry_regression import EntryRegressions
from tsd_casadi.generalization.suggestion import Region, Suggestion
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.declaration import Declaration

# motions, robots and contexts that are asked about; a stranger may ask for any
MOST_KNOWN = 1_000
# what SQLite takes for a number without a bound
ALL = 2**62


class Reading:
    """One connection that asks, for one thread at a time.

    Every method sees the file as it was at one moment, whatever is written meanwhile.

    Attributes:
        path: The file.
    """

    def __init__(self, path: str | Path, kept: KeptEntries | None = None) -> None:
        """Open a file that a ``Database`` has opened before, and has still.

        Args:
            kept: Decoded entries, shared with other connections to the file.

        Raises:
            DatabaseError: If it cannot be opened.
        """
        self.path = Path(os.path.expanduser(path))  # leaves an unknown user's as it is
        self._kept = kept or KeptEntries()
        self._file = self._open()
        self._rows = EntryRows(self._file, self._kept)
        self._index = EntryIndex(self._file)
        self._regressions = EntryRegressions()
        self._version = self._file.version()
        self._known: dict[tuple[str, str | None, str | None, Context | None], Answers] = {}

    def _open(self) -> DatabaseFile:
        return DatabaseFile.to_read(self.path)

    def __repr__(self) -> str:
        """Name the file."""
        return f"<{type(self).__name__} {self.path}>"

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Self:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()

    def entries(self, robot: str | None = None, motion: str | None = None) -> list[Entry]:
        """Read entries, in the order of their identifiers; ``damaged`` lists what is missing.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.
        """
        with self._file.transaction():
            return self._rows.read(robot, motion)[0]

    def damaged(self, robot: str | None = None, motion: str | None = None) -> list[DamagedEntry]:
        """List entries that cannot be read.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.
        """
        with self._file.transaction():
            return self._rows.read(robot, motion)[1]

    def outlines(
        self,
        robot: str | None = None,
        motion: str | None = None,
        *,
        most: int = ALL,
        after: int | None = None,
    ) -> Outlines:
        """List entries and what cannot be read; no weights are decoded.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.
            most: Number of entries; those that were recorded last.
            after: Those that come after this number instead, to read page by page.
        """
        with self._file.transaction():
            if after is None:
                numbers = self._index.newest(robot, motion, most)
                found = self._index.count(robot, motion)
            else:
                numbers = self._index.above(robot, motion, after, most)
                found = self._index.count_above(robot, motion, after)
            entries, damaged = self._rows.outlines(numbers)
        return Outlines(entries, damaged, found - len(numbers))

    def version(self) -> object:
        """Give what is another whenever somebody has written to the file."""
        return self._file.version()

    def state(self) -> DatabaseState:
        """Tell how the file is, without reading an entry."""
        with self._file.transaction():
            times = self._file.execute("SELECT time FROM event ORDER BY id DESC LIMIT 1")
            entries = self._index.count()
        return DatabaseState(
            path=str(self.path),
            schema_version=SCHEMA_VERSION,
            entries=entries,
            damaged=self._kept.damaged,
            size=self._file.size(),
            last_write=times[0][0] if times else None,
        )

    def query(
        self,
        motion: str,
        /,
        *,
        robot: str | None = None,
        kind: str | None = None,
        extrapolate: bool = False,
        axes: Sequence[str] | None = None,
        context: Context | None = None,
        version: str | None = None,
        **parameters: float,
    ) -> Feedforward:
        """Look up or generalise the feedforward for some parameters of a motion.

        Args:
            motion: Name of the motion, for instance 'squat'.
            robot: May be left out while there is only one.
            kind: 'learned' for the exact entry, 'generalised' for a regression
                over the other entries; by default the exact entry where there
                is one.
            extrapolate: Generalise outside the learned range too.
            axes: Along which it is wanted, names 'task.axis'. An entry for fewer
                of them serves too: the answer names those that it knows.
            context: In which it is wanted; by default that of the newest
                recording, and the answer counts the entries of others. Entries
                of unknown context serve where there is no other.
            version: Of the motion; that of the newest recording by default.
            parameters: SI units; those with a default may be left out.

        Raises:
            InvalidValue: If a parameter is missing or makes no sense, or the
                kind is unknown, or there are too many entries to generalise over.
            EntryNotFound: If nothing fits.
            OutsideTrainedRange: If it would be an extrapolation.
            DatabaseError: If the entry with these parameters is damaged.
        """
        if kind not in (None, "learned", "generalised"):
            raise InvalidValue("kind", repr(kind), "learned or generalised")
        with self._file.transaction():
            answers = self._answers(motion, robot, version, context)
            if kind != "generalised":
                exact = answers.exact(parameters, axes)
                if isinstance(exact, DamagedEntry):
                    raise exact.error(self.path)
                if exact is not None:
                    return exact
            if kind == "learned":
                raise answers.not_learned(parameters, axes)
            comparable = answers.comparable(axes)
        return answers.generalize(
            comparable, parameters, axes, self._regressions, extrapolate=extrapolate
        )

    def suggest(
        self,
        motion: str,
        /,
        *,
        robot: str | None = None,
        region: Region,
        axes: Sequence[str] | None = None,
        context: Context | None = None,
        version: str | None = None,
        **parameters: float,
    ) -> Suggestion:
        """Choose the parameters of a motion whose repetition would teach most.

        Args:
            motion: Name of the motion, for instance 'squat'.
            robot: May be left out while there is only one.
            region: (low, high) of each parameter that may be chosen, SI units.
            axes: As in ``query``.
            context: As in ``query``.
            version: As in ``query``.
            parameters: The others, SI units; those with a default may be left out
                once something is known of the motion.

        Returns:
            Parameters, with the predicted standard deviation there.

        Raises:
            InvalidValue: If a parameter is missing or makes no sense, or the
                region is empty, or there are too many entries to compare.
            EntryNotFound: If the entries do not fit together, or every place in
                the region has one.
        """
        with self._file.transaction():
            answers = self._answers(motion, robot, version, context)
            comparable = answers.comparable(axes)
        return answers.suggestion(comparable, region, parameters, self._regressions)

    def _answers(
        self, motion: str, robot: str | None, version: str | None, context: Context | None
    ) -> Answers:
        # what is asked over and over, as long as nobody writes
        if (now := self._file.version()) != self._version or len(self._known) > MOST_KNOWN:
            self._version, self._known = now, {}
        asked = motion, robot, version, context
        if asked not in self._known:
            self._known[asked] = self._new_answers(*asked)
        return self._known[asked]

    def _new_answers(
        self, motion: str, robot: str | None, version: str | None, context: Context | None
    ) -> Answers:
        if robot is None:
            robots = self._index.robots(motion)
            if len(robots) > 1:
                raise EntryNotFound(f"name the robot, the database knows {', '.join(robots)}")
            robot = robots[0] if robots else ""
        groups = self._index.groups(robot, motion)
        answering = Answering.among(motion, groups, version, context)
        declaration = self._declaration(robot, motion, answering.version)
        return Answers(robot, answering, declaration, self._index, self._rows)

    def _declaration(self, robot: str, motion: str, version: str | None) -> Declaration:
        """Find what was said last of one version of a motion."""
        for event in self._index.declared(robot, motion, version or ""):
            declaration = self._rows.declaration(event)
            if declaration is not None:
                return declaration
        return Declaration.unknown(motion, version or "")
