"""What rows of the table 'iteration' hold, with their weights and without."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Field, Json

from tsd_casadi.database.row import Row, without_checksum
from tsd_casadi.document import to_matrix
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.state import Matrix

Numbers = list[list[float]]


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
        return cls.model_validate(without_checksum(columns))

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
