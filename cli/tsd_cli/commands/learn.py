"""'tsd learn': repeat and learn."""

from __future__ import annotations

from tsd_cli.option_groups import with_groups
from tsd_cli.options.film import FilmOptions
from tsd_cli.options.learning import LearningOptions, PlaceOptions
from tsd_cli.options.motion import MotionOptions, RepetitionOptions
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.pace import PaceOptions
from tsd_cli.options.robot import SimulatedRobotOptions
from tsd_cli.options.services import ServiceOptions
from tsd_cli.options.telemetry import TelemetryOptions


@with_groups
def learn(
    motion: MotionOptions,
    learning: LearningOptions,
    places: PlaceOptions,
    repetition: RepetitionOptions,
    time: PaceOptions,
    body: SimulatedRobotOptions,
    services: ServiceOptions,
    film: FilmOptions,
    watching: TelemetryOptions,
    output: JsonOptions,
) -> None:
    """Learn a motion's feedforward by repeating it; continues an existing entry.

    Two iterations are three runs, the last one shows how good it became:

      tsd learn squat --amplitude 0.04 --iterations 2 --model-error 0.1

    A film of the last lap of each run, in which the error shrinks:

      tsd learn squat --model-error 0.1 --video learning.gif

    With --auto N the learner says where, N times: where its feedforward is most
    uncertain.

      tsd learn squat --auto 4 --region amplitude=0.02:0.08 --model-error 0.1
    """
    from tsd_cli.actions.learn import learn_by_repetition

    learn_by_repetition(
        motion,
        learning,
        places,
        repetition,
        time,
        body,
        services,
        film,
        watching,
        output,
    )
