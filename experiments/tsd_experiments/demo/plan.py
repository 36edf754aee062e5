"""Which squats the demonstration does."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.gains import Gains

MODEL_ERROR = 0.1
REDUCED = Gains(P=0.2)  # P / 5, D as it is
REUSED = "nearest entry as it is"
ALL_AXES = "all axes"


@dataclass(frozen=True)
class Plan:
    """The squats of the demonstration.

    Attributes:
        frequency: Of all squats [Hz].
        amplitude: What is learned and then run at lower gains [m].
        database: What is learned to generalise from [m].
        queried: What is generalised to [m].
        nearest: The entry that is used there as it is [m].
        iterations: Learning iterations of each.
    """

    frequency: float = 0.25
    amplitude: float = 0.03
    database: tuple[float, ...] = (0.02, 0.04, 0.06, 0.08)
    queried: float = 0.05
    nearest: float = 0.04
    iterations: int = 2

    @property
    def squats(self) -> list[Squat]:
        """All squats that the robot has to be able to do."""
        amplitudes = (self.amplitude, *self.database, self.queried)
        return [Squat(amplitude, self.frequency) for amplitude in amplitudes]

    @property
    def number_of_runs(self) -> int:
        """How many repetitions that makes."""
        learning = self.iterations + 1
        # learned, perfect, constant and twice P/5; all axes; the database;
        # learned, generalised and nearest
        return learning + 4 + learning + learning * len(self.database) + learning + 2


def label_of(amplitude: float, what: str) -> str:
    """Name a run for people.

    Args:
        amplitude: [m].
    """
    return f"{100 * amplitude:g} cm, {what}"


def file_name(label: str) -> str:
    """Name a run's file."""
    return label.replace("/", "_").replace(", ", "_").replace(" ", "_")
