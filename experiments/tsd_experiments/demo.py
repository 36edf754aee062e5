"""The whole idea in a few minutes: learning, lower gains, generalisation.

Both services run as processes of their own with a fresh database; every run
asks the controller over Zenoh at every tick.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import Any

from tsd_casadi.exceptions import TsdError
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_casadi.repetition.learn import learn
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.version import __version__
from tsd_clients.console.progress import show_progress
from tsd_clients.console.run_tables import print_goals, print_runs
from tsd_clients.console.table import console
from tsd_clients.logs.log_file import save_log as write_log
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_clients.viewer.rendering import render_squat
from tsd_experiments.harness.services import start_services
from tsd_experiments.report.figures import draw_feedback, draw_tracking

FREQUENCY = 0.25  # Hz
MODEL_ERROR = 0.1
REDUCED = Gains(P=0.2)  # P / 5, D as it is
AMPLITUDE = 0.03  # m
DATABASE = (0.02, 0.04, 0.06, 0.08)  # m
QUERIED, NEAREST = 0.05, 0.04  # m
REUSED = "nearest entry as it is"
ITERATIONS = 2


class _Demo:
    """The runs of the demonstration, in order."""

    def __init__(
        self,
        robot: Robot,
        controller: RemoteController,
        learner: RemoteLearner,
        seed: int,
        save_log: Callable[[str, Run], None],
    ) -> None:
        self.robot = robot
        self._save_log = save_log
        self.controller = controller
        self.learner = learner
        self.seed = seed
        self.runs: dict[str, Run] = {}
        self._done = 0

    def play(self, report: Any) -> None:
        """Do all runs; report(done, total) moves the bar."""
        self._report = report
        self._simulator = MujocoSimulator(self.robot, MODEL_ERROR)
        self._perfect_model()
        self._one_amplitude()
        self._other_amplitude()

    def _perfect_model(self) -> None:
        simulator = MujocoSimulator(self.robot, 0.0)
        self._run(_label(AMPLITUDE, "perfect model, none"), AMPLITUDE, simulator=simulator)

    def _one_amplitude(self) -> None:
        runs = self._learn(AMPLITUDE)
        self._run(_label(AMPLITUDE, "constant"), AMPLITUDE, runs[1].feedforward.constant())
        self._run(_label(AMPLITUDE, "P/5, none"), AMPLITUDE, gains=REDUCED)
        self._run(
            _label(AMPLITUDE, "P/5, learned, iteration 1"), AMPLITUDE, runs[1].feedforward, REDUCED
        )

    def _other_amplitude(self) -> None:
        # the generalisation is to know the amplitudes of the database only
        for entry in self.learner.database().entries:
            self.learner.forget(entry.entry)
        for amplitude in DATABASE:
            self._learn(amplitude)
        robot = self.robot.name
        generalized = self.learner.query(
            Squat.name, robot=robot, kind="generalised", amplitude=QUERIED, frequency=FREQUENCY
        )
        self._run(_label(QUERIED, "generalised"), QUERIED, generalized)
        nearest = self.learner.query(
            Squat.name, robot=robot, kind="learned", amplitude=NEAREST, frequency=FREQUENCY
        )
        self._run(_label(QUERIED, REUSED), QUERIED, replace(nearest, kind="nearest"))
        self._learn(QUERIED)

    def _learn(self, amplitude: float) -> list[Run]:
        def keep(run: Run, notes: list[str]) -> None:
            iteration = run.feedforward.iteration
            kind = f"learned, iteration {iteration}" if iteration else "none"
            self._keep(_label(amplitude, kind), run)
            for note in notes:
                console.print(f"note: {note}")

        return learn(
            self._simulator,
            self.controller,
            [Squat(amplitude, FREQUENCY)],
            self.learner,
            iterations=ITERATIONS,
            seed=self.seed,
            transport="zenoh",
            progress=lambda _motion, _index: self._progress,
            on_run=keep,
        )

    def _run(
        self,
        label: str,
        amplitude: float,
        feedforward: Feedforward | None = None,
        gains: Gains = UNCHANGED,
        simulator: MujocoSimulator | None = None,
    ) -> None:
        run = (simulator or self._simulator).run(
            self.controller,
            Squat(amplitude, FREQUENCY),
            feedforward=feedforward,
            gains=gains,
            seed=self.seed,
            transport="zenoh",
            progress=self._progress,
        )
        self._keep(label, run)

    def _progress(self, done: float, total: float) -> None:
        self._report(self._done + done / total, _number_of_runs())

    def _keep(self, label: str, run: Run) -> None:
        self._done += 1
        self.runs[label] = run
        self._save_log(label, run)


def run_demo(robot: Robot, out: Path, seed: int = 0) -> dict[str, Any]:
    """Run the demonstration and write its results.

    Args:
        out: Folder for summary.json, per-tick logs and figures.

    Returns:
        The summary.

    Raises:
        InvalidValue: If the robot cannot do one of the squats.
        TsdError: If a service does not start or a run fails.
    """
    start = monotonic()
    for amplitude in (AMPLITUDE, *DATABASE, QUERIED):
        Squat(amplitude, FREQUENCY).check(robot)
    try:
        (out / "logs").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TsdError(f"cannot write to {out}: {error}; choose another with --out") from error
    written: list[Future[None]] = []

    # compressing a log takes half a second, which the next run does not need to wait
    console.print("starting the controller (the first start compiles it, about 20 s)")
    with ThreadPoolExecutor(1) as writer, start_services(robot) as (controller, learner):

        def save_log(label: str, run: Run) -> None:
            written.append(writer.submit(write_log, run, out / "logs" / f"{_file_name(label)}.npz"))

        demo = _Demo(robot, controller, learner, seed, save_log)
        with show_progress("demo", _number_of_runs()) as report:
            demo.play(report)
        served = controller.info().ticks_served
    runs = demo.runs
    summary = {
        "robot": robot.name,
        "version": __version__,
        "gains": next(iter(runs.values())).gains,
        "runs": [{"label": label, **run.summary()} for label, run in runs.items()],
        "ticks_served": served,
        "goals": _goals(runs),
        "seconds": monotonic() - start,
    }
    for future in written:
        future.result()  # an error while writing is an error
    _draw(runs, out)
    pictures = render_squat(robot, runs[_label(AMPLITUDE, "learned, iteration 1")], out)
    summary["seconds"] = monotonic() - start
    (out / "summary.json").write_text(json.dumps(summary, indent=2))
    _print(summary, out, pictures)
    return summary


def _number_of_runs() -> int:
    learning = ITERATIONS + 1
    # learned, perfect, constant and twice P/5; the database; learned,
    # generalised and nearest
    return learning + 4 + learning * len(DATABASE) + learning + 2


def _label(amplitude: float, what: str) -> str:
    return f"{100 * amplitude:g} cm, {what}"


def _file_name(label: str) -> str:
    return label.replace("/", "_").replace(", ", "_").replace(" ", "_")


def _draw(runs: dict[str, Run], out: Path) -> None:
    first = runs[_label(AMPLITUDE, "learned, iteration 1")]
    one = {
        "no feedforward": (runs[_label(AMPLITUDE, "none")], "none"),
        "learned, 1 iteration": (first, "learned"),
        "learned, P / 5": (runs[_label(AMPLITUDE, "P/5, learned, iteration 1")], "reduced"),
    }
    other = {
        "no feedforward": (runs[_label(QUERIED, "none")], "none"),
        "learned, 2 iterations": (runs[_label(QUERIED, "learned, iteration 2")], "learned"),
        "generalised": (runs[_label(QUERIED, "generalised")], "reduced"),
    }
    wrong = f"{100 * MODEL_ERROR:g} % wrong model"
    draw_tracking(one, f"{100 * AMPLITUDE:g} cm squat, {wrong}", out / "com_error.png")
    draw_feedback(one, first, out / "feedback.png")
    known = ", ".join(f"{100 * amplitude:g}" for amplitude in DATABASE)
    title = f"{100 * QUERIED:g} cm squat, generalised from {known} cm, {wrong}"
    draw_tracking(other, title, out / "generalisation.png")


def _goals(runs: dict[str, Run]) -> list[dict[str, Any]]:
    """What the method promises, as ratios of two runs of this demonstration."""
    none, constant, perfect, first, second, reduced = (
        runs[_label(AMPLITUDE, what)]
        for what in (
            "none",
            "constant",
            "perfect model, none",
            "learned, iteration 1",
            "learned, iteration 2",
            "P/5, learned, iteration 1",
        )
    )
    generalized, direct, nearest = (
        runs[_label(QUERIED, what)] for what in ("generalised", "learned, iteration 2", REUSED)
    )
    ac_none = none.ac_rms_error
    measured = [
        ("RMS error, none / one iteration", ">= 80", none.rms_error / first.rms_error),
        ("AC error, none / one iteration", ">= 5", ac_none / first.ac_rms_error),
        ("AC error, none / two iterations", ">= 25", ac_none / second.ac_rms_error),
        (
            "mean |feedback|, none / one iteration",
            ">= 80",
            none.mean_abs_feedback / first.mean_abs_feedback,
        ),
        ("RMS error, none at P / learned at P/5", ">= 20", none.rms_error / reduced.rms_error),
        ("AC error, none / constant (must miss 5)", "< 5", ac_none / constant.ac_rms_error),
        (
            "AC error, generalised / learned directly",
            "<= 1.5",
            generalized.ac_rms_error / direct.ac_rms_error,
        ),
        (
            "AC error, generalised / nearest entry",
            "<= 0.3",
            generalized.ac_rms_error / nearest.ac_rms_error,
        ),
        ("RMS error in mm, perfect model", "< 0.02", 1e3 * perfect.rms_error),
    ]
    return [
        {"id": name, "goal": goal, "measured": value, "met": _is_met(goal, value)}
        for name, goal, value in measured
    ]


def _is_met(goal: str, value: float) -> bool:
    relation, bound = goal.split()
    return {
        ">=": value >= float(bound),
        "<=": value <= float(bound),
        "<": value < float(bound),
    }[relation]


def _print(summary: dict[str, Any], out: Path, pictures: str) -> None:
    ticks = sum(run["ticks"] for run in summary["runs"])
    print_runs(
        f"{summary['robot']}, {FREQUENCY} Hz, model error {100 * MODEL_ERROR:g} % unless said, "
        "every tick over Zenoh",
        summary["runs"],
    )
    print_goals(summary["goals"])
    console.print(
        f"{ticks} ticks, {summary['ticks_served']} counted by the controller; "
        f"{summary['seconds']:.0f} s. {pictures}\n"
        f"summary, logs and figures in {out}"
    )
