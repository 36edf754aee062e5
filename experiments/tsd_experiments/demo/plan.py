"""Which squats the demonstration does."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.motions.motion import declared_parameters
from tsd_casadi.motions.ranges import range_of
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.robot.robot import Robot

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

    @classmethod
    def of(cls, robot: Robot) -> Plan:
        """Plan squats at the same shares of a robot's range as of the paper's robot.

        Raises:
            InvalidValue: If the robot has no task that carries a squat.
        """
        (amplitude,) = (x for x in declared_parameters(Squat) if x.name == "amplitude")
        _, largest = range_of(robot, Squat, amplitude)
        share = largest / max(cls.database)
        (one, queried, nearest), database = (
            # a tenth of a millimetre, so that people and databases read the same number
            tuple(round(share * size, 4) for size in sizes)
            for sizes in ((cls.amplitude, cls.queried, cls.nearest), cls.database)
        )
        return cls(amplitude=one, database=database, queried=queried, nearest=nearest)

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
