"""How far the simulated robot is from the model that the controller was given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.state import Vector

LOWEST, HIGHEST = -0.9, 9.0


@dataclass(frozen=True)
class ModelError:
    """Relative errors of mass and inertia, link by link.

    A link's mass and inertia are 1 + E times too large in the controller's
    model; the simulated link is that much lighter.

    Attributes:
        uniform: E of every link, a fraction.
        per_link: Magnitude of a further error with random sign per link.
        seed: Of the signs.
    """

    uniform: float = 0.0
    per_link: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse what leaves a link without mass.

        Raises:
            InvalidValue: If an error is out of range.
        """
        for value in (self.uniform - abs(self.per_link), self.uniform + abs(self.per_link)):
            if not LOWEST <= value <= HIGHEST:
                raise InvalidValue(
                    "model error", value, f"a fraction from {LOWEST} to {HIGHEST:g}, 0.1 is 10 %"
                )

    def factors(self, links: int) -> Vector:
        """Draw mass and inertia of model over simulated robot, link by link, (links,)."""
        signs = np.random.default_rng(self.seed).choice((-1.0, 1.0), size=links)
        return np.asarray(1 + self.uniform + self.per_link * signs)

    def settings(self) -> dict[str, float]:
        """Write the error as plain data for a run's records."""
        if self.per_link == 0.0:
            return {"model_error": self.uniform}
        return {
            "model_error": self.uniform,
            "link_error": self.per_link,
            "link_error_seed": self.seed,
        }
