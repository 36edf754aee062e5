"""Which entries answer a question: context, version of the motion and axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from tsd_casadi.database.entry_index import Group, IndexedEntry
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry_key import EntryKey

UNKNOWN_CONTEXT = (
    "learned before fingerprints were written down: nobody knows for which body and formulation"
)


@dataclass(frozen=True)
class Answering:
    """Which entries of a motion on one robot may answer.

    Attributes:
        motion: Name of the motion.
        version: Of it; None while nothing is known of the motion.
        context: That of the answer; None while nothing is known of the motion.
        groups: Entries that are comparable: those of the context, then those of
            which it is unknown.
        others: Number of entries of other contexts.
    """

    motion: str
    version: str | None
    context: Context | None
    groups: tuple[tuple[Group, ...], ...]
    others: int

    @classmethod
    def among(
        cls, motion: str, groups: Sequence[Group], version: str | None, context: Context | None
    ) -> Answering:
        """Choose among all that is known of a motion on one robot.

        Args:
            version: Of the motion; that of the newest recording if None.
            context: That of the newest recording if None.
        """
        of_version = [group for group in groups if version in (None, group.version)]
        if not of_version:
            return cls(motion, version, context, (), 0)
        if context is None:
            context = _newest(of_version).context
        own = [group for group in of_version if group.context == context]
        unknown = [
            group for group in of_version if not group.context.is_known and group.context != context
        ]
        others = _size(of_version) - _size(own) - _size(unknown)
        if version is None:
            version = _newest(own or unknown or of_version).version
        served = (
            tuple(group for group in groups if group.version == version)
            for groups in (own, unknown)
        )
        return cls(motion, version, context, tuple(each for each in served if each), others)

    @property
    def size(self) -> int:
        """Number of entries that may answer."""
        return sum(_size(group) for group in self.groups)

    def provenance(self, used: EntryKey) -> dict[str, Any]:
        """Say in which context an answer was learned.

        Args:
            used: Key of an entry that it comes from.
        """
        note = {} if used.context.is_known else {"note": UNKNOWN_CONTEXT}
        return {"context": dict(vars(used.context)), "others": self.others, **note}


def by_axes(
    entries: Sequence[IndexedEntry], axes: Sequence[str] | None
) -> list[list[IndexedEntry]]:
    """Sort entries into those of the same axes, the group to be preferred first.

    Args:
        axes: What is asked for: the exact ones first, then those that know most
            of them. The newest first if None.
    """
    # in one order: of what other software wrote, or an older one, weights do not go together
    groups: dict[tuple[str, ...], list[IndexedEntry]] = {}
    for entry in entries:
        known = entry.key.axes
        if axes is None or set(known) <= set(axes):
            groups.setdefault(known, []).append(entry)

    def preference(group: list[IndexedEntry]) -> tuple[int, tuple[int, str, int]]:
        last = max(group, key=lambda entry: entry.age)
        return (0 if axes is None else len(last.key.axes)), last.age

    return sorted(groups.values(), key=preference, reverse=True)


def _newest(groups: Sequence[Group]) -> Group:
    return max(groups, key=lambda group: group.newest)


def _size(groups: Sequence[Group]) -> int:
    return sum(group.entries for group in groups)
