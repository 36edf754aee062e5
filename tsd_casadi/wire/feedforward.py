"""A feedforward term on the network: the project's most public contract."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from tsd_casadi.document import Document, Finite, to_matrix
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.feedforward import Feedforward, Kind
from tsd_casadi.motions.parameter import unit_of


class QuantityMessage(Document):
    """A number with its unit."""

    value: Finite
    unit: str

    @classmethod
    def of(cls, motion: str, name: str, value: float) -> QuantityMessage:
        """Describe the value of a motion's parameter."""
        return cls(value=value, unit=unit_of(motion, name))


def plain_parameters(motion: str, parameters: dict[str, QuantityMessage]) -> dict[str, float]:
    """Check the units of a motion's parameters and drop them.

    Raises:
        MalformedMessage: If a unit is not the parameter's.
    """
    for name, quantity in parameters.items():
        if quantity.unit != unit_of(motion, name):
            raise MalformedMessage(
                f"{name} of a {motion} in '{quantity.unit}'", f"'{unit_of(motion, name)}'"
            )
    return {name: quantity.value for name, quantity in parameters.items()}


class BasisMessage(Document):
    """A periodic basis, eqs. (basis_functions) and (psi) of the paper.

    Attributes:
        type: Always 'periodic_rbf'.
        L: Number of functions.
        centres: c_j [rad].
        width: h.
    """

    type: Literal["periodic_rbf"] = "periodic_rbf"
    L: Annotated[int, Field(ge=1, le=1000)]
    centres: tuple[Finite, ...]
    width: Annotated[float, Field(gt=0, lt=1e6)]

    @classmethod
    def of(cls, basis: PeriodicBasis) -> BasisMessage:
        """Describe a basis."""
        return cls(L=basis.L, centres=tuple(basis.centers), width=basis.width)

    def basis(self) -> PeriodicBasis:
        """Make the basis.

        Raises:
            MalformedMessage: If the centres are not 2 pi j / L.
        """
        basis = PeriodicBasis(self.L, self.width)
        if len(self.centres) != self.L or not np.allclose(
            self.centres, basis.centers, rtol=0, atol=1e-9
        ):
            raise MalformedMessage("basis.centres", "2 pi j / L for j = 0 ... L - 1")
        return basis


class FeedforwardMessage(Document):
    """A feedforward term: the project's most public contract.

    Attributes:
        format: Name and version of this message.
        robot: Name of the robot.
        task: Name of the motion.
        axes: Names 'task.axis', k of them, world axes.
        parameters: Of the motion, with units.
        unit: Unit of weights and standard deviations.
        basis: The basis.
        weights: k rows of L numbers.
        standard_deviations: Weights of the predictive standard deviation over
            the phase, in the same basis.
        kind: 'learned' or 'generalised'.
        provenance: Entries used, iteration, errors, gains.
    """

    format: Literal["tsd.feedforward/1"] = "tsd.feedforward/1"
    robot: str
    task: str
    axes: Annotated[tuple[str, ...], Field(min_length=1)]
    parameters: dict[str, QuantityMessage]
    unit: Literal["m/s^2"] = "m/s^2"
    basis: BasisMessage
    weights: list[list[Finite]]
    standard_deviations: list[list[Finite]]
    kind: Kind
    provenance: dict[str, Any]

    @classmethod
    def of(cls, robot: str, motion: str, feedforward: Feedforward) -> FeedforwardMessage:
        """Describe a feedforward."""
        return cls(
            robot=robot,
            task=motion,
            axes=feedforward.axes,
            parameters={
                name: QuantityMessage.of(motion, name, value)
                for name, value in feedforward.parameters.items()
            },
            basis=BasisMessage.of(feedforward.basis),
            weights=feedforward.weights.tolist(),
            standard_deviations=feedforward.standard_deviations.tolist(),
            kind=feedforward.kind,
            provenance=feedforward.provenance,
        )

    def feedforward(self) -> Feedforward:
        """Make the feedforward.

        Raises:
            MalformedMessage: If shapes or units do not fit.
        """
        shape = (len(self.axes), self.basis.L)
        deviations = to_matrix("standard_deviations", self.standard_deviations, shape)
        if (deviations < 0).any():
            raise MalformedMessage("a negative standard deviation", "none below zero")
        entries, iteration = (self.provenance.get(name) for name in ("entries", "iteration"))
        if not isinstance(entries, list) or type(iteration) is not int:
            raise MalformedMessage(
                f"provenance with entries {entries!r}, iteration {iteration!r}",
                "a list of entries and the number of an iteration",
            )
        return Feedforward(
            axes=self.axes,
            basis=self.basis.basis(),
            weights=to_matrix("weights", self.weights, shape),
            standard_deviations=deviations,
            kind=self.kind,
            parameters=plain_parameters(self.task, self.parameters),
            provenance=self.provenance,
        )
