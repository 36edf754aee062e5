"""Where to learn next, on the network."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from tsd_casadi.document import Finite, Name
from tsd_casadi.generalization.suggestion import Suggestion
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.wire.context import NOBODY_KNOWS, ContextMessage
from tsd_casadi.wire.declaration import (
    DeclarationMessage,
    QuantityMessage,
    plain_parameters,
    quantities,
)
from tsd_casadi.wire.message import Instance, Message, VersionText


class SuggestionMessage(Message):
    """The parameters of a motion whose repetition would teach most.

    Attributes:
        format: Name and version of this message.
        instance: Id of the service.
        robot: Name of the robot.
        motion: Name of the motion.
        version: Of the motion.
        parameters: Of the motion, with units.
        standard_deviation: Of the feedforward predicted there, RMS over the lap
            and the axes, in their units by s^2; null while there are too few
            entries to tell.
        context: Of the entries that count.
        others: Number of entries of the motion in other contexts.
        declaration: What is said of the motion; null while nothing is known of it.
        provenance: Which entries count, plain data.
    """

    format: Literal["tsd.suggestion/2"] = "tsd.suggestion/2"
    instance: Instance = 0
    robot: str
    motion: Name
    version: VersionText = ""
    parameters: dict[str, QuantityMessage]
    standard_deviation: Annotated[Finite, Field(ge=0)] | None
    context: ContextMessage = NOBODY_KNOWS
    others: Annotated[int, Field(ge=0)] = 0
    declaration: DeclarationMessage | None = None
    provenance: Annotated[dict[str, Any], Field(default_factory=dict)]

    @classmethod
    def of(
        cls, robot: str, motion: str, suggestion: Suggestion, instance: int = 0
    ) -> SuggestionMessage:
        """Describe a suggestion.

        Args:
            instance: Id of the service.
        """
        declaration = suggestion.declaration or Declaration.unknown(motion)
        provenance = suggestion.provenance
        return cls(
            instance=instance,
            robot=robot,
            motion=motion,
            version=declaration.version,
            parameters=quantities(declaration, suggestion.parameters),
            standard_deviation=suggestion.standard_deviation,
            context=ContextMessage.of_provenance(provenance),
            others=provenance.get("others", 0),
            declaration=DeclarationMessage.of(declaration) if declaration.parameters else None,
            provenance=provenance,
        )

    def suggestion(self) -> Suggestion:
        """Make the suggestion.

        Raises:
            MalformedMessage: If a unit is not the parameter's.
        """
        declaration = (
            Declaration.unknown(self.motion, self.version)
            if self.declaration is None
            else self.declaration.declaration()
        )
        return Suggestion(
            plain_parameters(declaration, self.parameters),
            self.standard_deviation,
            self.provenance,
            declaration,
        )
