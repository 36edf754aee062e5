"""Which entries answer a question: context, version of the motion and axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.motions.declaration import Declaration

UNKNOWN_CONTEXT = (
    "learned before fingerprints were written down: nobody knows for which body and formulation"
)


@dataclass(frozen=True)
class Answering:
    """The entries of a motion on one robot that may answer.

    Attributes:
        context: That of the answer; None while nothing is known of the motion.
        declaration: What was said last of the motion.
        groups: Entries that are comparable, by context: those of the context,
            then those of which it is unknown.
        others: Number of entries of other contexts.
    """

    context: Context | None
    declaration: Declaration
    groups: tuple[list[Entry], ...]
    others: int

    @classmethod
    def among(
        cls, motion: str, entries: Sequence[Entry], version: str | None, context: Context | None
    ) -> Answering:
        """Choose among all entries of a motion on one robot.

        Args:
            version: Of the motion; that of the newest recording if None.
            context: That of the newest recording if None.
        """
        of_version = [entry for entry in entries if version in (None, entry.key.version)]
        if not of_version:
            return cls(context, Declaration.unknown(motion, version or ""), (), 0)
        if context is None:
            context = newest(of_version).key.context
        own = [entry for entry in of_version if entry.key.context == context]
        unknown = [
            entry
            for entry in of_version
            if not entry.key.context.is_known and entry.key.context != context
        ]
        others = len(of_version) - len(own) - len(unknown)
        if version is None:
            version = newest(own or unknown or of_version).key.version
        groups = (
            [entry for entry in group if entry.key.version == version] for group in (own, unknown)
        )
        return cls(
            context,
            declaration_of(motion, version, of_version),
            tuple(group for group in groups if group),
            others,
        )

    @property
    def entries(self) -> list[Entry]:
        """All of them."""
        return [entry for group in self.groups for entry in group]

    def provenance(self, used: Entry) -> dict[str, Any]:
        """Say in which context an answer was learned.

        Args:
            used: An entry that it comes from.
        """
        context = used.key.context
        note = {} if context.is_known else {"note": UNKNOWN_CONTEXT}
        return {"context": asdict(context), "others": self.others, **note}


def newest(entries: Sequence[Entry]) -> Entry:
    """Find the entry that was recorded last."""
    return max(entries, key=lambda entry: (entry.sequence, entry.updated, entry.identifier))


def declaration_of(motion: str, version: str, entries: Sequence[Entry]) -> Declaration:
    """Find what was said last of one version of a motion."""
    told = [
        entry for entry in entries if entry.key.version == version and entry.declaration is not None
    ]
    declaration = newest(told).declaration if told else None
    return declaration or Declaration.unknown(motion, version)


def by_axes(entries: Sequence[Entry], axes: Sequence[str] | None) -> list[list[Entry]]:
    """Sort entries into those of the same axes, the group to be preferred first.

    Args:
        axes: What is asked for: the exact ones first, then those that know most
            of them. The newest first if None.
    """
    groups: dict[frozenset[str], list[Entry]] = {}
    for entry in entries:
        known = frozenset(entry.key.axes)
        if axes is None or known <= set(axes):
            groups.setdefault(known, []).append(entry)

    def preference(group: list[Entry]) -> tuple[int, int, str, int]:
        last = newest(group)
        size = 0 if axes is None else len(last.key.axes)
        return size, last.sequence, last.updated, last.identifier

    return sorted(groups.values(), key=preference, reverse=True)
