"""'tsd reproduce': experiments, figures, report and summary."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from time import monotonic
from typing import Any

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.catalogue import find_motion
from tsd_casadi.motions.ranges import check_motion
from tsd_casadi.robot.robot import Robot
from tsd_clients.console.progress import console, show_progress
from tsd_clients.simulator.effects import check_effects
from tsd_experiments.beyond.any_motion.experiment import AnyMotion
from tsd_experiments.beyond.bootstrapping import Bootstrapping
from tsd_experiments.beyond.borrowed_feedforward.experiment import BorrowedFeedforward
from tsd_experiments.beyond.learning_at_low_gain import LearningAtLowGain
from tsd_experiments.beyond.stiffness_or_feedforward.experiment import StiffnessOrFeedforward
from tsd_experiments.beyond.true_center_of_mass.experiment import TrueCenterOfMass
from tsd_experiments.beyond.two_parameters.experiment import TwoParameters
from tsd_experiments.comparison.experiment import InsteadOfLearning
from tsd_experiments.comparison.scenario import SCENARIOS
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.duration import time_taken
from tsd_experiments.harness.experiment import Experiment
from tsd_experiments.harness.job import Result
from tsd_experiments.harness.measurements import write_measurements
from tsd_experiments.harness.run_jobs import cores, run_jobs
from tsd_experiments.harness.section import Goal
from tsd_experiments.harness.store import Store
from tsd_experiments.paper.figure_4_generalization import AmplitudeGeneralization
from tsd_experiments.paper.figure_5_stand_in import StandIn
from tsd_experiments.paper.figure_6_stills import Stills, movie
from tsd_experiments.paper.figures_2_3_tracking import Tracking
from tsd_experiments.paper.model_errors import ModelErrors
from tsd_experiments.report.circumstances import circumstances
from tsd_experiments.report.html_page import write_html
from tsd_experiments.report.markdown_page import write_markdown
from tsd_experiments.report.save_figures import save_figures

EXPERIMENTS: tuple[type[Experiment], ...] = (
    Tracking,
    AmplitudeGeneralization,
    StandIn,
    Stills,
    ModelErrors,
    Bootstrapping,
    StiffnessOrFeedforward,
    InsteadOfLearning,
    LearningAtLowGain,
    TwoParameters,
    BorrowedFeedforward,
    TrueCenterOfMass,
    AnyMotion,
)


def choose_experiments(figure: int | None, quick: bool) -> list[Experiment]:
    """Choose the experiments of a figure of the paper, or all.

    Raises:
        InvalidValue: If no experiment reproduces that figure.
    """
    chosen = [kind(quick) for kind in EXPERIMENTS if figure is None or figure in kind.figures]
    if not chosen:
        known = sorted({number for kind in EXPERIMENTS for number in kind.figures})
        raise InvalidValue("figure", figure, f"one of {', '.join(map(str, known))}")
    return chosen


def reproduce(
    robot: Robot, out: Path, *, figure: int | None, quick: bool, page: Path | None
) -> dict[str, Any]:
    """Run what is not done yet and write the report.

    Args:
        out: Folder of data, figures, report and summary.
        figure: Only this figure of the paper.
        page: Markdown file to write as well, its figures in a folder beside it.

    Returns:
        The summary.

    Raises:
        InvalidValue: If no experiment reproduces that figure, or the robot cannot
            do what they ask for.
        TsdError: If something cannot be written or a service does not start.
    """
    experiments = choose_experiments(figure, quick)
    check_cases(experiments, robot)
    store = Store(out / "data", robot)
    done = run_all(experiments, store)
    start = monotonic()
    write_measurements(done, out)
    sections = [experiment.report(done) for experiment in experiments]
    pictures = save_figures(sections, out / "figures")
    film = movie(done, robot)
    if film is not None:
        (out / "figures" / "squat.gif").write_bytes(film)
    seconds = {
        "experiments": time_taken(result.span for result in done.values()),
        "report": monotonic() - start,
    }
    goals = [goal for section in sections for goal in section.goals]
    if figure is None:
        goals += duration_goals(quick, sum(seconds.values()) / 60)
    made_with = {**circumstances(robot, quick), "seconds": seconds}
    write_html(sections, goals, pictures, film, made_with, out / "report.html")
    if page is not None:
        folder = page.with_suffix("")
        folder.mkdir(parents=True, exist_ok=True)
        for name, picture in pictures.items():
            (folder / f"{name}.png").write_bytes(picture)
        write_markdown(sections, goals, made_with, folder.name, page)
    summary = {**made_with, "rows": [goal.plain() for goal in goals]}
    (out / "summary.json").write_text(json.dumps(summary, indent=2))
    return summary


def check_cases(experiments: Sequence[Experiment], robot: Robot) -> None:
    """Refuse a robot that cannot do what the experiments ask for, before anything runs.

    Raises:
        InvalidValue: If a motion is out of the robot's range, or an axis missing.
        RobotFileError: If the robot file has no section 'hardware'.
    """
    arguments = [job.arguments for experiment in experiments for job in experiment.jobs({})]
    for case in (Case.of(each["case"]) for each in arguments if "case" in each):
        check_motion(robot, case.motion)
        check_effects(robot, case.hardware)
    for each in (each for each in arguments if "motion" in each):
        motion = find_motion(each["motion"])(**each["parameters"])
        motion.axes(robot)  # may not be there
        check_motion(robot, motion)
        check_effects(robot, each.get("hardware", ()))
    for scenario in (SCENARIOS[each["scenario"]] for each in arguments if "scenario" in each):
        for squat in scenario.transfers.values():
            check_motion(robot, squat)
        check_effects(robot, scenario.hardware)


def duration_goals(quick: bool, minutes: float) -> list[Goal]:
    """Compare how long it took with how long it may take.

    Args:
        minutes: What it took [min].
    """
    return [
        Goal("tsd reproduce --quick on two cores [min]", "<= 5", minutes if quick else None),
        Goal("tsd reproduce on two cores [min]", "<= 45", None if quick else minutes),
    ]


def run_all(experiments: Sequence[Experiment], store: Store) -> dict[str, Result]:
    """Run jobs until no experiment can name a new one.

    Args:
        store: Where results are kept; what is there is not run again.

    Returns:
        Results by job name.
    """
    done: dict[str, Result] = {}
    stage = 0
    while True:
        jobs = [job for experiment in experiments for job in experiment.jobs(done)]
        pending = {job.name: job for job in jobs if job.name not in done}
        if not pending:
            return done
        for name, job in list(pending.items()):
            kept = store.load(job)
            if kept is not None:
                done[name] = kept
                del pending[name]
        if not pending:
            continue
        stage += 1
        # bars are for terminals only; a log should tell as well that work is under way
        work = sum(job.cost for job in pending.values()) / cores() / 60
        console.print(f"stage {stage}: {len(pending)} jobs, at most {work:.0f} minutes or so")
        with show_progress(f"stage {stage}, {len(pending)} jobs", 1.0) as report:
            done.update(run_jobs(list(pending.values()), store, report))
