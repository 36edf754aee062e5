"""In which context and how something was learned, on the network."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field

from tsd_casadi.document import Document, Finite, Name
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context

Fingerprint = Annotated[str, Field(pattern=r"^[A-Za-z0-9_.:+-]*$", max_length=200)]
LARGEST_SETTING = 20_000


class ContextMessage(Document):
    """What must be the same for entries to be comparable; empty where nobody knows.

    Attributes:
        body: Fingerprint of kinematics, masses and inertias, as the controller
            believes them.
        formulation: Fingerprint of tasks, contacts and cost terms.
        correction: Fingerprint of the estimated centre of mass; empty for none.
    """

    body: Fingerprint
    formulation: Fingerprint
    correction: Fingerprint = ""

    @classmethod
    def of(cls, context: Context) -> ContextMessage:
        """Describe a context."""
        return cls(**vars(context))

    @classmethod
    def of_provenance(cls, provenance: Mapping[str, Any]) -> ContextMessage:
        """Describe the context that a provenance names, if any."""
        context = provenance.get("context")
        return NOBODY_KNOWS if context is None else cls(**context)

    def context(self) -> Context:
        """Make the context."""
        return Context(**self.model_dump())


NOBODY_KNOWS = ContextMessage(body="", formulation="")


class CircumstancesMessage(Document):
    """How a repetition was made.

    Attributes:
        gains: P and D of the learned axes [1/s^2, 1/s].
        setting: What else a record should say, plain data.
        version: Of the software.
        allowed: Largest acceleration along each learned axis that the torque limits
            allow at the motion [unit/s^2]; empty if nobody said.
    """

    gains: dict[Name, Annotated[list[Finite], Field(max_length=50)]]
    setting: Annotated[dict[str, Any], Field(default_factory=dict)]
    version: Annotated[str, Field(max_length=100)] = ""
    allowed: Annotated[list[Finite], Field(default_factory=list, max_length=50)]

    @classmethod
    def of(cls, circumstances: Circumstances) -> CircumstancesMessage:
        """Describe circumstances."""
        return cls(**vars(circumstances))

    def circumstances(self) -> Circumstances:
        """Make the circumstances.

        Raises:
            MalformedMessage: If the setting is too long.
        """
        size = len(json.dumps(self.setting))
        if size > LARGEST_SETTING:
            raise MalformedMessage(f"a setting of {size} bytes", f"at most {LARGEST_SETTING}")
        return Circumstances(**self.model_dump())
