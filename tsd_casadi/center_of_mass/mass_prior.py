"""What is known of the masses and of the measurements before any pose was measured."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.exceptions import InvalidValue

NOISE = 5e-4  # m, of a pose's averaged centre of pressure


@dataclass(frozen=True)
class MassPrior:
    """How far a robot's model may be off, as standard deviations.

    Attributes:
        mass: s_m, of each link's mass, a fraction of it.
        center: s_l, of each link's centre of mass, along each axis [m].
    """

    mass: float = 0.1
    center: float = 0.005

    def __post_init__(self) -> None:
        """Refuse what is no uncertainty.

        Raises:
            InvalidValue: If one is negative or both are zero.
        """
        for name, value, most in (("mass", self.mass, 10.0), ("center", self.center, 1.0)):
            if not 0 <= value <= most:
                raise InvalidValue(f"prior {name}", value, f"from 0 to {most:g}")
        if self.mass == self.center == 0:
            raise InvalidValue("prior", "certain", "a mass or a centre that may be off")
