"""Makes the moving picture of the README: G1, simulated, learns a squat."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.database.database import Database
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.learn import learn
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_clients.film.clip import Clip, last_lap, make_clip
from tsd_clients.film.make_film import make_film
from tsd_clients.film.video_file import GIF_RATE
from tsd_clients.simulator.simulator import MujocoSimulator

TARGET = Path(__file__).with_name("g1_learning.gif")
SIZE = (480, 360)  # pixels
# the controller believes every link lighter than it is, and has a third of its stiffness
MODEL_ERROR, GAINS = -0.1, Gains.critical(1 / 3)
MOTION = Squat(amplitude=0.03, frequency=0.5)
ITERATIONS = 3
RULE: RuleName = "guarded"


def film_learning() -> list[Clip]:
    """Learn, and keep the last lap of each repetition."""
    robot = load_robot("g1")
    clips: list[Clip] = []

    def keep(run: Run, notes: list[str]) -> None:
        iteration = run.feedforward.iteration or 0
        print(f"iteration {iteration}: {run}", *notes, sep="\n  ")
        clips.append(_clip(robot, run, f"iteration {iteration}"))

    with TemporaryDirectory() as folder, Database(Path(folder) / "database.sqlite") as database:
        learn(
            MujocoSimulator(robot, MODEL_ERROR),
            compile_controller(robot),
            [MOTION],
            database,
            gains=GAINS,
            iterations=ITERATIONS,
            rule=RULE,
            on_run=keep,
        )
    title = f"G1 learns a squat: its model is {-100 * MODEL_ERROR:g} % too light"
    make_film(robot, clips, TARGET, title, SIZE)
    return clips


def _clip(robot: Robot, run: Run, label: str) -> Clip:
    fields, plotted = last_lap(run.log), len(run.learned)
    return make_clip(robot, fields, run.axes, rate=GIF_RATE, label=label, plotted=plotted)


if __name__ == "__main__":
    film_learning()
    print(f"{TARGET}: {TARGET.stat().st_size / 1e6:.2f} MB")
