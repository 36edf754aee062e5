"""What a row of each table holds, checked as it is read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field, Json

from tsd_casadi.database.iteration_rows import IterationOutline
from tsd_casadi.database.row import Row
from tsd_casadi.document import Document, Finite
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.motions.declaration import Declaration

EventKind = Literal["recorded", "imported", "migrated", "forgotten"]


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
