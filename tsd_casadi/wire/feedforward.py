"""A feedforward term on the network: the project's most public contract."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any, Literal

from pydantic import Field

from tsd_casadi.document import Document, Finite, Name, to_matrix
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.band import Band
from tsd_casadi.learning.bound import Bound
from tsd_casadi.learning.feedforward import Feedforward, Kind
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.wire.axis import Axes, NotNegative, axis_messages, plain_axes
from tsd_casadi.wire.basis import BasisMessage
from tsd_casadi.wire.context import NOBODY_KNOWS, ContextMessage
from tsd_casadi.wire.declaration import (
    DeclarationMessage,
    QuantityMessage,
    plain_parameters,
    quantities,
)
from tsd_casadi.wire.message import Instance, Message, VersionText


class BandMessage(Document):
    """How far the feedforward may be off.

    Attributes:
        kind: 'pointwise' at each phase by itself, 'simultaneous' for whole laps.
        coverage: Share of phases or laps that it is meant to hold.
        half_width: Weights of half its width, k rows of L numbers.
    """

    kind: Literal["pointwise", "simultaneous"]
    coverage: Annotated[float, Field(gt=0, lt=1)]
    half_width: list[list[NotNegative]]

    @classmethod
    def of(cls, band: Band) -> BandMessage:
        """Describe a band."""
        return cls(kind=band.kind, coverage=band.coverage, half_width=band.half_width.tolist())

    def band(self, shape: tuple[int, int]) -> Band:
        """Make the band.

        Args:
            shape: Of the feedforward's weights, (k, L).

        Raises:
            MalformedMessage: If its own are others.
        """
        return Band(self.kind, self.coverage, to_matrix("half_width", self.half_width, shape))


class BoundMessage(Document):
    """What the feedforward was bounded by.

    Attributes:
        largest: Largest absolute value along each axis, k numbers [unit/s^2].
        reason: Where it comes from.
    """

    largest: list[NotNegative]
    reason: Annotated[str, Field(max_length=200)] = ""

    def bound(self, k: int) -> Bound:
        """Make the bound.

        Args:
            k: Number of axes.

        Raises:
            MalformedMessage: If there is not one for each axis.
        """
        if len(self.largest) != k:
            raise MalformedMessage(f"a bound of {len(self.largest)} axes", f"one for each of {k}")
        return Bound(tuple(self.largest), self.reason)


class FeedforwardMessage(Message):
    """A feedforward term: the project's most public contract.

    Attributes:
        format: Name and version of this message.
        instance: Id of the service.
        robot: Name of the robot.
        motion: Name of the motion.
        version: Of the motion.
        axes: k of them; weights are in their unit by s^2.
        parameters: Of the motion, with units.
        basis: The basis.
        weights: k rows of L numbers [unit/s^2].
        standard_deviations: Weights of the predictive standard deviation over
            the phase, in the same basis, k rows of L numbers [unit/s^2]. Of a learned
            term the standard deviation of each weight that the scatter of the laps
            leaves, the same for all of an axis; zero if unknown.
        kind: 'learned' or 'generalised'.
        context: In which it was learned.
        others: Number of entries of the motion in other contexts.
        epoch: Counts how often the robot had changed before.
        declaration: What is said of the motion.
        bands: How far it may be off, besides the standard deviations.
        bound: What it was bounded by.
        provenance: Entries used, iteration, errors, gains.
    """

    format: Literal["tsd.feedforward/2"] = "tsd.feedforward/2"
    instance: Instance = 0
    robot: str
    motion: Name
    version: VersionText = ""
    axes: Axes
    parameters: dict[str, QuantityMessage]
    basis: BasisMessage
    weights: list[list[Finite]]
    standard_deviations: list[list[Finite]]
    kind: Kind
    context: ContextMessage = NOBODY_KNOWS
    others: Annotated[int, Field(ge=0)] = 0
    epoch: Annotated[int, Field(ge=0)] = 0
    declaration: DeclarationMessage | None = None
    bands: list[BandMessage] | None = None
    bound: BoundMessage | None = None
    provenance: dict[str, Any]

    @classmethod
    def of(
        cls, robot: str, motion: str, feedforward: Feedforward, instance: int = 0
    ) -> FeedforwardMessage:
        """Describe a feedforward.

        Args:
            instance: Id of the service.
        """
        declaration = feedforward.declaration or Declaration.unknown(motion)
        provenance = feedforward.provenance
        return cls(
            instance=instance,
            robot=robot,
            motion=motion,
            version=declaration.version,
            axes=axis_messages(feedforward.axes),
            parameters=quantities(declaration, feedforward.parameters),
            basis=BasisMessage.of(feedforward.basis),
            weights=feedforward.weights.tolist(),
            standard_deviations=feedforward.standard_deviations.tolist(),
            kind=feedforward.kind,
            context=ContextMessage.of_provenance(provenance),
            others=provenance.get("others", 0),
            epoch=provenance.get("epoch", 0),
            declaration=DeclarationMessage.of(declaration) if declaration.parameters else None,
            bound=None if feedforward.bound is None else BoundMessage(**asdict(feedforward.bound)),
            bands=[BandMessage.of(band) for band in feedforward.bands] or None,
            provenance=provenance,
        )

    def feedforward(self) -> Feedforward:
        """Make the feedforward.

        Raises:
            MalformedMessage: If shapes or units do not fit.
        """
        axes = plain_axes(self.axes)
        shape = (len(axes), self.basis.L)
        deviations = to_matrix("standard_deviations", self.standard_deviations, shape)
        if (deviations < 0).any():
            raise MalformedMessage("a negative standard deviation", "none below zero")
        entries, iteration = (self.provenance.get(name) for name in ("entries", "iteration"))
        if not isinstance(entries, list) or type(iteration) is not int:
            raise MalformedMessage(
                f"provenance with entries {entries!r}, iteration {iteration!r}",
                "a list of entries and the number of an iteration",
            )
        declaration = (
            Declaration.unknown(self.motion, self.version)
            if self.declaration is None
            else self.declaration.declaration()
        )
        return Feedforward(
            axes=axes,
            basis=self.basis.basis(),
            weights=to_matrix("weights", self.weights, shape),
            standard_deviations=deviations,
            kind=self.kind,
            parameters=plain_parameters(declaration, self.parameters),
            # a client looks at it again
            provenance={**self.provenance, "robot": self.robot},
            declaration=declaration,
            bound=None if self.bound is None else self.bound.bound(len(axes)),
            bands=tuple(band.band(shape) for band in self.bands or ()),
        )
