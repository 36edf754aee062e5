"""What a row of each table holds, checked as it is read."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, Json

from tsd_casadi.document import Document, to_matrix
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.recording import Context
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.state import Matrix

# a measure of a repetition may be unknown, the RMS error is not
Measure = Annotated[float, Field(allow_inf_nan=True)]
Rows = list[list[float]]


class ContextColumn(Document):
    """Circumstances of the recordings, in the column 'context'."""

    formulation: str
    model: str
    gains: dict[str, list[float]]
    version: str


class EntryRow(Document):
    """A row of the table 'entry'; the fields are its columns."""

    id: int
    robot: str
    task: str
    axes: Json[Annotated[tuple[str, ...], Field(min_length=1)]]
    parameters: Json[dict[str, float]]
    basis_size: Annotated[int, Field(ge=1, le=100_000)]
    basis_width: float
    context: Json[ContextColumn]
    learning_gain: float
    rule: str
    updated: str

    def entry(self, iterations: list[IterationRow]) -> Entry:
        """Build the entry with its iterations.

        Raises:
            MalformedMessage: If weights are of another shape than axes and basis.
            InvalidValue: If the basis makes no sense or the rule is unknown.
        """
        basis = PeriodicBasis(self.basis_size, self.basis_width)
        shape = len(self.axes), basis.L
        return Entry(
            key=EntryKey.of(self.robot, self.task, self.axes, self.parameters),
            basis=basis,
            context=Context(**self.context.model_dump()),
            iterations=[row.iteration(shape) for row in iterations],
            learning_gain=self.learning_gain,
            rule=find_rule(self.rule),
            identifier=self.id,
            updated=self.updated,
        )


class IterationRow(Document):
    """A row of the table 'iteration'; the fields are its columns but the first."""

    number: int
    learned_from: int | None
    weights: Json[Rows]
    errors: Json[dict[str, Measure]] | None
    gains: Json[dict[str, list[float]]] | None
    feedback: Json[Rows] | None
    error_weights: Json[Rows] | None
    reference_weights: Json[Rows] | None

    def iteration(self, shape: tuple[int, int]) -> Iteration:
        """Build the iteration.

        Args:
            shape: Of the weights, (k, L).

        Raises:
            MalformedMessage: If weights are of another shape or the RMS error is missing.
        """
        if self.errors is not None and not self.errors.get("rms_error_m", -1.0) >= 0:
            raise MalformedMessage("errors without a valid rms_error_m", "an RMS error in metres")

        def matrix(name: str) -> Matrix | None:
            rows = getattr(self, name)
            return None if rows is None else to_matrix(name, rows, shape)

        return Iteration(
            number=self.number,
            weights=to_matrix("weights", self.weights, shape),
            errors=self.errors,
            gains=self.gains,
            feedback=matrix("feedback"),
            error_weights=matrix("error_weights"),
            reference_weights=matrix("reference_weights"),
            learned_from=self.learned_from,
        )
