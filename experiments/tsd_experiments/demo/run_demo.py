"""The demonstration with its results: summary, logs, figures and tables."""

from __future__ import annotations

import json
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from time import monotonic
from typing import Any

from matplotlib import pyplot as plt

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.ranges import check_motion
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.version import __version__
from tsd_clients.console.progress import show_progress
from tsd_clients.console.run_tables import print_goals, print_runs
from tsd_clients.console.table import console
from tsd_clients.film.rendering import render_extremes
from tsd_clients.logs.log_file import save_log as write_log
from tsd_experiments.demo.goals import goals_of
from tsd_experiments.demo.plan import MODEL_ERROR, Plan, file_name, label_of
from tsd_experiments.demo.runs import DemoRuns
from tsd_experiments.harness.outcome import row_of
from tsd_experiments.harness.services import start_services
from tsd_experiments.report.curve import Curve
from tsd_experiments.report.drawing import draw_feedback, draw_tracking


def run_demo(robot: Robot, out: Path, seed: int = 0, plan: Plan | None = None) -> dict[str, Any]:
    """Run the demonstration and write its results.

    Args:
        out: Folder for summary.json, per-tick logs and figures.
        plan: The squats; those of the robot's range if left out.

    Returns:
        The summary.

    Raises:
        InvalidValue: If the robot cannot do one of the squats, or the folder be written.
        TsdError: If a service does not start or a run fails.
    """
    start = monotonic()
    plan = plan or Plan.of(robot)
    for squat in plan.squats:
        check_motion(robot, squat)
    try:
        (out / "logs").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidValue(
            "the folder for results",
            f"'{out}' ({error.strerror})",
            "one that you may write to; choose another with --out",
        ) from error
    written: list[Future[None]] = []

    # compressing a log takes half a second, which the next run does not need to wait
    console.print("starting the controller (the first start compiles it, about 20 s)")
    with ThreadPoolExecutor(1) as writer, start_services(robot) as (controller, learner):

        def save_log(label: str, run: Run) -> None:
            written.append(writer.submit(write_log, run, out / "logs" / f"{file_name(label)}.npz"))

        demo = DemoRuns(robot, controller, learner, plan, seed, save_log)
        with show_progress("demo", plan.number_of_runs) as report:
            demo.play(report)
        served = controller.info().ticks_served
    runs = demo.runs
    summary = {
        "robot": robot.name,
        "version": __version__,
        "gains": next(iter(runs.values())).gains,
        "runs": [{"label": label, **run.summary(), **row_of(run)} for label, run in runs.items()],
        "ticks_served": served,
        "goals": [goal.plain() for goal in goals_of(runs, plan, robot.description.demo_goals)],
        "seconds": monotonic() - start,
    }
    for future in written:
        future.result()  # an error while writing is an error
    _draw(runs, plan, out)
    pictures = render_extremes(robot, runs[label_of(plan.amplitude, "learned, iteration 1")], out)
    summary["seconds"] = monotonic() - start
    (out / "summary.json").write_text(json.dumps(summary, indent=2))
    _print(summary, plan, out, pictures)
    return summary


def _draw(runs: Mapping[str, Run], plan: Plan, out: Path) -> None:
    def curve(legend: str, amplitude: float, what: str, style: str) -> Curve:
        return Curve.of(legend, runs[label_of(amplitude, what)], style)

    one = [
        curve("no feedforward", plan.amplitude, "none", "none"),
        curve("learned, 1 iteration", plan.amplitude, "learned, iteration 1", "learned"),
        curve("learned, P / 5", plan.amplitude, "P/5, learned, iteration 1", "reduced"),
    ]
    other = [
        curve("no feedforward", plan.queried, "none", "none"),
        curve("learned, 2 iterations", plan.queried, "learned, iteration 2", "learned"),
        curve("generalised", plan.queried, "generalised", "reduced"),
    ]
    wrong = f"{100 * MODEL_ERROR:g} % wrong model"
    known = ", ".join(f"{100 * amplitude:g}" for amplitude in plan.database)
    title = f"{100 * plan.queried:g} cm squat, generalised from {known} cm, {wrong}"
    for name, figure in {
        "com_error": draw_tracking(one, f"{100 * plan.amplitude:g} cm squat, {wrong}"),
        "feedback": draw_feedback(one, one[1]),
        "generalization": draw_tracking(other, title),
    }.items():
        figure.savefig(out / f"{name}.png", dpi=130)
        plt.close(figure)


def _print(summary: dict[str, Any], plan: Plan, out: Path, pictures: str) -> None:
    ticks = sum(run["ticks"] for run in summary["runs"])
    print_runs(
        f"{summary['robot']}, {plan.frequency} Hz, model error {100 * MODEL_ERROR:g} % "
        "unless said, every tick over Zenoh",
        summary["runs"],
    )
    print_goals(summary["goals"])
    console.print(
        f"{ticks} ticks, {summary['ticks_served']} counted by the controller; "
        f"{summary['seconds']:.0f} s. {pictures}\n"
        f"summary, logs and figures in {out}"
    )
    log = out / "logs" / f"{file_name(label_of(plan.amplitude, 'learned, iteration 1'))}.npz"
    console.print(
        f"Look at it: 'tsd log video {log} squat.mp4' makes a film of a run, "
        f"'tsd view --log {log}' shows it in a browser, 'tsd view' what runs now; --video of "
        "simulate and learn makes a film at once."
    )
