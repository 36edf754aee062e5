"""Feedforward and suggestions from the entries that may answer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from tsd_casadi.database.answering import Answering, by_axes
from tsd_casadi.database.damaged_entry import DamagedEntry
from tsd_casadi.database.entry_index import EntryIndex, Group, IndexedEntry, Parameters
from tsd_casadi.database.entry_rows import EntryRows
from tsd_casadi.exceptions import EntryNotFound, InvalidValue, OutsideTrainedRange
from tsd_casadi.generalization.entry_regression import (
    MOST_ENTRIES,
    MOST_TOLD,
    EntryRegressions,
    describe_entries,
    describe_motion,
)
from tsd_casadi.generalization.suggestion import Region, Suggestion, suggest
from tsd_casadi.learning.bound import Bound
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.declaration import Declaration


class Answers:
    """Answers questions on one motion of one robot, in the reader's transaction."""

    def __init__(
        self,
        robot: str,
        answering: Answering,
        declaration: Declaration,
        index: EntryIndex,
        rows: EntryRows,
    ) -> None:
        """Take what is asked about.

        Args:
            answering: The entries that may.
            declaration: What was said last of the motion.
        """
        self._robot = robot
        self._answering = answering
        self._declaration = declaration
        self._index = index
        self._rows = rows

    def exact(
        self, parameters: Mapping[str, float], axes: Sequence[str] | None
    ) -> Feedforward | DamagedEntry | None:
        """Look up the entry of these parameters, and decode what it serves.

        Returns:
            The feedforward, or what keeps it from being read; None without an entry.
        """
        first: DamagedEntry | None = None
        answering = self._answering
        found = self._index.at(self._robot, answering.motion, self._wanted(parameters))
        for group in answering.groups:
            for same_axes in by_axes([each for each in found if _is_of(each, group)], axes):
                for indexed in sorted(same_axes, key=lambda each: each.age, reverse=True):
                    entry = self._rows.served(indexed)
                    if isinstance(entry, Entry):
                        return self._told(entry.feedforward(), indexed.key)
                    first = first or entry
        return first

    def comparable(self, axes: Sequence[str] | None) -> list[list[Entry]]:
        """Read entries with what they serve, by context and axes, those to be preferred first.

        Raises:
            InvalidValue: If they are too many.
        """
        if self._answering.size > MOST_ENTRIES:
            raise InvalidValue(
                f"entries of the {self._answering.motion} to be compared",
                str(self._answering.size),
                f"at most {MOST_ENTRIES}: forget some, or ask for parameters that were learned",
            )
        found = []
        for groups in self._answering.groups:
            entries = [each for group in groups for each in self._of(group, MOST_ENTRIES)]
            entries.sort(key=lambda each: each.identifier)
            found += by_axes(entries, axes)
        read = ([self._rows.served(each) for each in same] for same in found)
        readable = ([each for each in same if isinstance(each, Entry)] for same in read)
        return [same for same in readable if same]

    def generalize(
        self,
        comparable: Iterable[list[Entry]],
        parameters: Mapping[str, float],
        axes: Sequence[str] | None,
        regressions: EntryRegressions,
        *,
        extrapolate: bool,
    ) -> Feedforward:
        """Generalise over the first of the comparable entries that are enough.

        Args:
            axes: That the entries are comparable for.
        """
        wanted = dict(self._wanted(parameters))
        first: EntryNotFound | OutsideTrainedRange | None = None
        for entries in comparable:
            try:
                predicted = regressions.generalize(self._declaration, entries, wanted, extrapolate)
            except (EntryNotFound, OutsideTrainedRange) as error:
                first = first or error
            else:
                return self._told(predicted.within(_bound(predicted, entries)), entries[0].key)
        if first is not None:
            raise first
        motion = self._declaration.motion
        raise EntryNotFound(
            f"nothing to generalise {describe_motion(motion, wanted.items())}{_along(axes)} from; "
            f"there is {self._described(axes)}. Learn some with 'tsd learn {motion}'"
        )

    def suggestion(
        self,
        comparable: Sequence[list[Entry]],
        region: Region,
        parameters: Mapping[str, float],
        regressions: EntryRegressions,
    ) -> Suggestion:
        """Choose where to learn next, by the first of the comparable entries."""
        answering = self._answering
        used = comparable[0] if comparable else []
        place = suggest(self._declaration, used, regressions, region, parameters)
        provenance = answering.provenance(used[0].key) if used else {"others": answering.others}
        return replace(place, provenance=provenance, declaration=self._declaration)

    def not_learned(
        self, parameters: Mapping[str, float], axes: Sequence[str] | None
    ) -> EntryNotFound:
        """Make the error of who asked for an exact entry."""
        motion = self._declaration.motion
        return EntryNotFound(
            f"no entry for {describe_motion(motion, self._wanted(parameters))}{_along(axes)}; "
            f"there is {self._described(axes)}. Learn it with 'tsd learn {motion}', or ask "
            "for a generalised feedforward"
        )

    def _wanted(self, parameters: Mapping[str, float]) -> Parameters:
        complete = self._declaration.complete(parameters)
        return EntryKey.of("", self._answering.motion, "", (), complete).parameters

    def _of(self, group: Group, most: int) -> list[IndexedEntry]:
        motion = self._answering.motion
        return self._index.of_group(self._robot, motion, group.version, group.context, most)

    def _told(self, feedforward: Feedforward, used: EntryKey) -> Feedforward:
        provenance = {**feedforward.provenance, **self._answering.provenance(used)}
        return replace(feedforward, provenance=provenance)

    def _described(self, axes: Sequence[str] | None) -> str:
        """Tell people what there is: some of it by name.

        Args:
            axes: That were asked for.
        """
        answering = self._answering
        found = [
            each.key
            for groups in answering.groups
            for group in groups
            for each in self._of(group, MOST_TOLD)
        ]
        elsewhere = f" (and {answering.others} of other contexts)" if answering.others else ""
        return describe_entries(found, answering.size, axes) + elsewhere


def _along(axes: Sequence[str] | None) -> str:
    return f" along {', '.join(axes)}" if axes else ""


def _bound(predicted: Feedforward, entries: Sequence[Entry]) -> Bound:
    """Bound what is generalised by what the entries that it comes from may be."""
    used = set(predicted.provenance["entries"])
    bounds = [
        dict(zip(each.key.axes, each.bound.largest, strict=True))
        for each in entries
        if each.identifier in used
    ]
    return Bound.among(predicted.axes, bounds)


def _is_of(entry: IndexedEntry, groups: Sequence[Group]) -> bool:
    return any(
        (entry.key.version, entry.key.context) == (group.version, group.context) for group in groups
    )
