"""'tsd simulate': one repetition."""

from __future__ import annotations

from tsd_cli.option_groups import with_groups
from tsd_cli.options.film import FilmOptions
from tsd_cli.options.motion import MotionOptions, SingleRepetitionOptions
from tsd_cli.options.output import LogOptions
from tsd_cli.options.pace import PaceOptions
from tsd_cli.options.robot import SimulatedRobotOptions
from tsd_cli.options.services import ServiceOptions
from tsd_cli.options.telemetry import TelemetryOptions


@with_groups
def simulate(
    motion: MotionOptions,
    repetition: SingleRepetitionOptions,
    time: PaceOptions,
    body: SimulatedRobotOptions,
    services: ServiceOptions,
    film: FilmOptions,
    watching: TelemetryOptions,
    output: LogOptions,
) -> None:
    """Simulate one repetition, asking the controller at every tick.

    A controller whose masses are 10 % wrong, without and with what was learned:

      tsd simulate squat --model-error 0.1
      tsd simulate squat --model-error 0.1 --feedforward learned

    In one process without any service, every tick written down:

      tsd simulate squat --controller local --log run.csv

    Against the clock, whatever happens to the controller; docs/reliability.md:

      tsd simulate squat --pace 1 --patience inf

    A film of it, and on a desktop a window while it moves; docs/films.md:

      tsd simulate squat --controller local --video squat.mp4
      tsd simulate squat --viewer --pace 1

    Another motion, with its own parameters, and one of your own:

      tsd simulate twist --amplitude 0.15 --frequency 0.5
      tsd simulate my_motion.py:Bounce --hop 0.02
    """
    from tsd_cli.actions.simulate import simulate_once

    simulate_once(motion, repetition, time, body, services, film, watching, output)
