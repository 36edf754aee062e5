"""The paper's last figure: one squat in pictures, and as a short film."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import pyplot as plt

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_clients.film.gl_library import HINT
from tsd_clients.film.rendering import Pictures, animate, render_postures
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.experiment import Done, Experiment
from tsd_experiments.harness.job import Job
from tsd_experiments.harness.learn_case import learn_case
from tsd_experiments.harness.outcome import Outcome, row_of
from tsd_experiments.harness.section import Figure, Section
from tsd_experiments.report.drawing import finish

JOB = "stills-lap"
RATE = 25  # pictures per second
STILLS = 8
WIDTH, HEIGHT = 240, 320  # pixels


def film(robot: Robot, controller: WholeBodyController, case: dict[str, Any]) -> Outcome:
    """Learn a squat once, do it again and keep its last lap.

    Returns:
        A row 'lap' with 'robot_file' and the run's summary; arrays 'q' (N, nq),
        'time' [s] and 'com_z' from the motion's middle [m] of the lap at ``RATE``.
    """
    used = Case.of(case)
    learned = learn_case(robot, controller, case, rule="plain", iterations=1)
    weights = learned.arrays["iteration 1/weights"][0].tolist()
    run = used.simulator(robot).run(
        controller,
        used.motion,
        axes=used.axes(robot),
        laps=used.laps,
        feedforward=used.feedforward(robot, weights, "learned"),
        gains=used.gains,
        seed=used.seed,
    )
    (axis,) = used.axes(robot)
    lap = run.log["lap"]
    ticks = np.flatnonzero(lap == lap.max())[:: round(1 / (RATE * run.settings["period_s"]))]
    return Outcome(
        rows=[{"label": "lap", "robot_file": str(robot.path), **row_of(run)}],
        arrays={
            "q": run.log["q"][ticks].astype(float),
            "time": run.log["time"][ticks] - run.log["time"][ticks[0]],
            "com_z": (run.along("reference", axis) - run.along("true_error", axis))[ticks],
        },
    )


def movie(done: Done, robot: Robot) -> bytes | None:
    """Make a GIF of one squat that repeats.

    Returns:
        The file's content; None if the squat was not among the jobs or no GL
        library can render it.
    """
    if JOB not in done:
        return None
    q = done[JOB].arrays["q"]
    frames = render_postures(robot, q, WIDTH, HEIGHT)
    return None if frames is None else animate(frames, len(q) / RATE)


class Stills(Experiment):
    """The learned squat to look at."""

    name = "stills"
    figures = (6,)

    def jobs(self, done: Done) -> list[Job]:
        """Learn one squat and keep it."""
        case = Case(laps=2, frequency=1.0 if self.quick else 0.25)
        return [Job(JOB, film, {"case": case.plain()}, cost=15)]

    def report(self, done: Done) -> Section:
        """Report the pictures, or what is missing to render them."""
        result = done[JOB]
        row, time, z = result.row("lap"), result.arrays["time"], result.arrays["com_z"]
        section = Section(
            title="One squat in pictures",
            claim="The paper: stills of the robot performing one squat.",
            found=[
                f"The centre of mass moves by {1e3 * float(np.ptp(z)):.1f} mm, the tracking error "
                f"is {1e3 * row['rms_error_m']:.3f} mm RMS."
            ],
        )
        moments = np.linspace(0, len(time), STILLS, endpoint=False).astype(int)
        frames = _render(Path(row["robot_file"]), result.arrays["q"][moments])
        if frames is None:
            section.found.append(HINT)
            return section
        section.figures.append(
            Figure(
                "stills",
                f"One squat, a picture every {time[moments[1]]:.2g} s.",
                lambda: _draw(frames, time[moments]),
            )
        )
        return section


def _render(robot_file: Path, postures: Any) -> Pictures | None:
    if not robot_file.exists():  # data from elsewhere
        return None
    return render_postures(load_robot(robot_file), postures, WIDTH, HEIGHT)


def _draw(frames: Pictures, times: Any) -> Any:
    figure, panels = plt.subplots(1, len(frames), figsize=(1.25 * len(frames), 2.1))
    for axes, frame, time in zip(panels, frames, times, strict=True):
        axes.imshow(frame)
        axes.set_title(f"{time:.2g} s", fontsize=8)
        axes.axis("off")
    return finish(figure)
