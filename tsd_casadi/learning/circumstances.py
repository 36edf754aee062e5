"""How a repetition was made: what tells tests of one entry apart, never what is served."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

# words of a setting that say which robot a simulation was of; the others say how it was run
HARDWARE = ("model_error", "link_error", "link_error_seed", "hardware")


@dataclass(frozen=True)
class Circumstances:
    """Of one recording.

    Attributes:
        gains: P and D of the learned axes, (k,) each [1/s^2, 1/s]. Errors at
            different gains say nothing about each other.
        setting: What else a record should say: simulated hardware, seed, period,
            plain data. Another hardware setting is another robot to the errors.
        version: Version of this software.
        allowed: Largest acceleration along each axis that the torque limits allow at
            the motion, (k,) [m/s^2, rad/s^2]; empty if nobody said.
    """

    gains: dict[str, list[float]]
    setting: dict[str, Any] = field(default_factory=dict)
    version: str = ""
    allowed: list[float] = field(default_factory=list)

    @property
    def hardware(self) -> dict[str, Any]:
        """What the setting says of the robot itself, as a simulation knows it."""
        return {name: value for name, value in self.setting.items() if name in HARDWARE}
