"""What a row of each table holds, checked as it is read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field, Json

from tsd_casadi.database.checksum import checksum
from tsd_casadi.document import AnyDocument, Document, Finite, to_matrix
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.state import Matrix

Numbers = list[list[float]]
EventKind = Literal["recorded", "imported", "migrated", "forgotten"]


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
        content = _without_checksum(columns)
        if columns["checksum"] != checksum(content):
            raise MalformedMessage("a row that does not fit its checksum", "it as it was written")
        return cls.model_validate(content)


def _without_checksum(columns: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in columns.items() if name != "checksum"}


class BasisColumn(Document):
    """The numbers of a periodic basis."""

    L: Annotated[int, Field(ge=1, le=100_000)]
    width: float


class EntryRow(Row):
    """A row of the table 'entry': what an entry is for."""

    id: Annotated[int, Field(ge=1)]
    robot: Annotated[str, Field(min_length=1)]
    motion: Annotated[str, Field(min_length=1)]
    version: str
    axes: Json[Annotated[tuple[str, ...], Field(min_length=1)]]
    parameters: Json[dict[str, Finite]]
    basis_kind: Literal["periodic"]
    basis: Json[BasisColumn]


class EventRow(Row):
    """A row of the table 'event': what happened to an entry, and how it is since."""

    id: int
    entry: int
    kind: EventKind
    time: str
    body: str
    formulation: str
    correction: str
    declaration: Json[Declaration] | None
    circumstances: Json[Circumstances]
    rule: str
    learning_gain: Finite


class IterationOutline(Row):
    """A row of the table 'iteration' without its weights, which are not decoded."""

    model_config = ConfigDict(extra="ignore")

    entry: int
    number: Annotated[int, Field(ge=0)]
    event: int
    learned_from: int | None
    epoch: Annotated[int, Field(ge=0)]
    errors: Json[dict[str, AxisError]] | None
    circumstances: Json[Circumstances] | None

    def iteration(self, axes: tuple[str, ...], L: int) -> Iteration:
        """Build the iteration with weights of no columns, (k, 0).

        Args:
            axes: Of the entry.
            L: Number of basis functions.

        Raises:
            MalformedMessage: If errors are of other axes.
        """
        if self.errors is not None:
            if tuple(self.errors) != axes:
                raise MalformedMessage(
                    f"errors of {', '.join(self.errors)}", f"of {', '.join(axes)}"
                )
            if not all(math.isfinite(e.rms) and e.rms >= 0 for e in self.errors.values()):
                raise MalformedMessage("errors without a valid RMS error", "a number not below 0")
        return Iteration(
            number=self.number,
            weights=np.empty((len(axes), 0)),
            errors=self.errors,
            circumstances=self.circumstances,
            learned_from=self.learned_from,
            epoch=self.epoch,
        )


class IterationRow(IterationOutline):
    """A row of the table 'iteration': how an iteration is since an event."""

    model_config = ConfigDict(extra="forbid")

    @classmethod
    def of_checked(cls, columns: Mapping[str, Any]) -> IterationRow:
        """Decode a row whose checksum its outline has checked.

        Raises:
            ValueError: If it makes no sense.
        """
        return cls.model_validate(_without_checksum(columns))

    weights: Json[Numbers]
    uncertainty: Json[Numbers] | None
    feedback: Json[Numbers] | None
    error_weights: Json[Numbers] | None
    reference_weights: Json[Numbers] | None

    def iteration(self, axes: tuple[str, ...], L: int) -> Iteration:
        """Build the iteration.

        Args:
            axes: Of the entry.
            L: Number of basis functions.

        Raises:
            MalformedMessage: If weights are of another shape or errors of other axes.
        """

        def matrix(name: str) -> Matrix | None:
            rows = getattr(self, name)
            return None if rows is None else to_matrix(name, rows, (len(axes), L))

        return replace(
            super().iteration(axes, L),
            weights=to_matrix("weights", self.weights, (len(axes), L)),
            feedback=matrix("feedback"),
            error_weights=matrix("error_weights"),
            reference_weights=matrix("reference_weights"),
            uncertainty=matrix("uncertainty"),
        )


def build(
    row: EntryRow, events: Sequence[EventRow], iterations: Sequence[IterationOutline]
) -> Entry:
    """Build an entry of what its rows say.

    Args:
        row: Of the table 'entry'.
        events: In their order, none of them 'forgotten'.
        iterations: The newest row of each number, in the order of the numbers.

    Raises:
        ValueError: If the rows do not fit together.
    """
    if not events or not iterations:
        raise MalformedMessage("no event or no iteration of it", "at least one of each")
    newest = events[-1]
    basis = PeriodicBasis(row.basis.L, row.basis.width)
    declarations = [event.declaration for event in events if event.declaration is not None]
    return Entry(
        key=EntryKey.of(
            row.robot,
            row.motion,
            row.version,
            row.axes,
            row.parameters,
            Context(newest.body, newest.formulation, newest.correction),
        ),
        basis=basis,
        circumstances=newest.circumstances,
        declaration=declarations[-1] if declarations else None,
        iterations=[each.iteration(row.axes, basis.L) for each in iterations],
        learning_gain=newest.learning_gain,
        rule=find_rule(newest.rule),
        identifier=row.id,
        updated=newest.time,
        sequence=max((event.id for event in events if event.kind == "recorded"), default=0),
    )
