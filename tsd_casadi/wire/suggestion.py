"""Where to learn next, on the network."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from tsd_casadi.document import Document, Finite
from tsd_casadi.generalization.suggestion import Suggestion
from tsd_casadi.wire.feedforward import QuantityMessage, plain_parameters


class SuggestionMessage(Document):
    """The parameters of a motion whose repetition would teach most.

    Attributes:
        format: Name and version of this message.
        robot: Name of the robot.
        task: Name of the motion.
        parameters: Of the motion, with units.
        standard_deviation: Of the feedforward predicted there, RMS over the lap
            and the axes; null while there are too few entries to tell.
        unit: Unit of the standard deviation.
    """

    format: Literal["tsd.suggestion/1"] = "tsd.suggestion/1"
    robot: str
    task: str
    parameters: dict[str, QuantityMessage]
    standard_deviation: Annotated[Finite, Field(ge=0)] | None
    unit: Literal["m/s^2"] = "m/s^2"

    @classmethod
    def of(cls, robot: str, motion: str, suggestion: Suggestion) -> SuggestionMessage:
        """Describe a suggestion."""
        return cls(
            robot=robot,
            task=motion,
            parameters={
                name: QuantityMessage.of(motion, name, value)
                for name, value in suggestion.parameters.items()
            },
            standard_deviation=suggestion.standard_deviation,
        )

    def suggestion(self) -> Suggestion:
        """Make the suggestion.

        Raises:
            MalformedMessage: If a unit is not the parameter's.
        """
        return Suggestion(plain_parameters(self.task, self.parameters), self.standard_deviation)
