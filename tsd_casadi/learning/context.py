"""What must be the same for entries to be comparable."""

from __future__ import annotations

from dataclasses import dataclass

UNKNOWN = ""


@dataclass(frozen=True)
class Context:
    """The body and the formulation that something was learned with; part of an entry's key.

    Attributes:
        body: Fingerprint of kinematics, masses and inertias, as the controller
            believes them.
        formulation: Fingerprint of tasks, contacts and cost terms.
        correction: Fingerprint of the estimated centre of mass; empty for none.

    ``UNKNOWN`` stands for what nobody wrote down.
    """

    body: str = UNKNOWN
    formulation: str = UNKNOWN
    correction: str = ""

    @property
    def is_known(self) -> bool:
        """Whether body and formulation are known."""
        return bool(self.body and self.formulation)


NOWHERE = Context()
