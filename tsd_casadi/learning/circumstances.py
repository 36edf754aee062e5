"""How a repetition was made: what tells tests of one entry apart, never what is served."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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


def tell_differences(hardware: Sequence[Mapping[str, Any]]) -> str:
    """Tell people in what simulated robots differ: 'model_error 0.1 or 0.2'.

    Args:
        hardware: As of ``Circumstances``; nothing is known of a robot that says nothing.

    Returns:
        Empty if they do not differ.
    """
    known = [each for each in hardware if each]
    told = []
    for name in dict.fromkeys(name for each in known for name in each):
        # plain data, a list of effects for instance, has no hash
        values = list(dict.fromkeys(str(each.get(name, "none")) for each in known))
        if len(values) > 1:
            told.append(f"{name} {' or '.join(values)}")
    return ", ".join(told)
