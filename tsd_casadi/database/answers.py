"""Feedforward and suggestions from the entries that may answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from tsd_casadi.database.answering import Answering, by_axes, newest
from tsd_casadi.database.damaged_entry import DamagedEntry
from tsd_casadi.exceptions import EntryNotFound, InvalidValue, OutsideTrainedRange
from tsd_casadi.generalization.entry_regression import (
    EntryRegressions,
    describe_entries,
    describe_motion,
)
from tsd_casadi.generalization.suggestion import Region, Suggestion, suggest
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.feedforward import Feedforward


class Answers:
    """Answers from entries, with regressions that are fitted again only when those changed."""

    def __init__(self, path: Path) -> None:
        """Fit nothing yet.

        Args:
            path: Of the database, for errors.
        """
        self._path = path
        self._regressions = EntryRegressions()

    def feedforward(
        self,
        answering: Answering,
        damaged: Sequence[DamagedEntry],
        parameters: Mapping[str, float],
        *,
        kind: str | None,
        extrapolate: bool,
        axes: Sequence[str] | None,
    ) -> Feedforward:
        """Look up or generalise; see ``Database.query``.

        Args:
            answering: The entries that may.
            damaged: Those of the motion that nobody can read.
        """
        if kind not in (None, "learned", "generalised"):
            raise InvalidValue("kind", repr(kind), "learned or generalised")
        motion = answering.declaration.motion
        complete = answering.declaration.complete(parameters)
        wanted = EntryKey.of("", motion, "", (), complete).parameters
        if kind in (None, "learned"):
            for group in answering.groups:
                exact = [entry for entry in group if entry.key.parameters == wanted]
                for same_axes in by_axes(exact, axes)[:1]:
                    entry = newest(same_axes)
                    return _told(entry.feedforward(), answering, entry)
            for each in damaged:
                if each.may_be(wanted):
                    raise each.error(self._path)
        if kind == "learned":
            raise EntryNotFound(
                f"no entry for {describe_motion(motion, wanted)}; there is "
                f"{describe_entries(answering.entries)}{_elsewhere(answering)}. Learn it with "
                f"'tsd learn {motion}', or ask for a generalised feedforward"
            )
        return self._generalize(answering, dict(wanted), extrapolate, axes)

    def suggestion(
        self,
        answering: Answering,
        region: Region,
        parameters: Mapping[str, float],
        axes: Sequence[str] | None,
    ) -> Suggestion:
        """Choose where to learn next; see ``Database.suggest``.

        Args:
            answering: The entries that count.
        """
        groups = [same for group in answering.groups for same in by_axes(group, axes)]
        used = groups[0] if groups else []
        place = suggest(answering.declaration, used, self._regressions, region, parameters)
        provenance = answering.provenance(used[0]) if used else {"others": answering.others}
        return replace(place, provenance=provenance, declaration=answering.declaration)

    def _generalize(
        self,
        answering: Answering,
        wanted: dict[str, float],
        extrapolate: bool,
        axes: Sequence[str] | None,
    ) -> Feedforward:
        """Generalise over the first entries that are enough, of one context and set of axes."""
        first: EntryNotFound | OutsideTrainedRange | None = None
        declaration = answering.declaration
        for group in answering.groups:
            for same_axes in by_axes(group, axes):
                try:
                    predicted = self._regressions.generalize(
                        declaration, same_axes, wanted, extrapolate
                    )
                except (EntryNotFound, OutsideTrainedRange) as error:
                    first = first or error
                else:
                    return _told(predicted, answering, same_axes[0])
        if first is not None:
            raise first
        raise EntryNotFound(
            f"nothing to generalise {describe_motion(declaration.motion, wanted.items())} from; "
            f"there is {describe_entries(answering.entries)}{_elsewhere(answering)}. Learn some "
            f"with 'tsd learn {declaration.motion}'"
        )


def _told(feedforward: Feedforward, answering: Answering, used: Entry) -> Feedforward:
    provenance = {**feedforward.provenance, **answering.provenance(used)}
    return replace(feedforward, provenance=provenance)


def _elsewhere(answering: Answering) -> str:
    return f" (and {answering.others} of other contexts)" if answering.others else ""
