"""The simulated robots and squats in which methods are compared."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_clients.simulator.model_error import ModelError
from tsd_experiments.harness.case import TALL

TEN_PERCENT = ModelError(0.1)
LARGER = 0.05  # m, the other amplitude


@dataclass(frozen=True)
class Scenario:
    """One simulated robot and the squat that is learned on it.

    Attributes:
        name: For the rows.
        squat: What is learned.
        other_frequency: What it is transferred to [Hz].
        hardware: Effects that count.
        model_error: Of the links.
        gains: Factors on the task's gains.
        seed: Of the starting randomness and the sensors' noise.
    """

    name: str
    squat: Squat
    other_frequency: float
    hardware: tuple[str, ...] = ()
    model_error: ModelError = TEN_PERCENT
    gains: Gains = UNCHANGED
    seed: int = 0

    @property
    def transfers(self) -> dict[str, Squat]:
        """The squat learned and the others, by what is changed."""
        A, f, h = self.squat.amplitude, self.squat.frequency, self.squat.height
        return {
            "none": self.squat,
            "amplitude": Squat(LARGER, f, h),
            "frequency": Squat(A, self.other_frequency, h),
            "posture": Squat(A, f, TALL),
        }


SCENARIOS = {
    "stand-in": Scenario("stand-in", Squat(0.03, 0.5), 0.25, hardware=("all",)),
    "ideal": Scenario("ideal", Squat(0.03, 0.25), 0.5),
}
