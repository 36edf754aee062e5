from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_experiments.harness.section import Goal, millimeters
from tsd_experiments.reproduce import EXPERIMENTS, check_cases, choose_experiments


@pytest.mark.parametrize(
    ("goal", "measured", "met"),
    [
        (">= 25", 25.0, True),
        (">= 25", 24.9, False),
        ("<= 0.12", 0.12, True),
        ("<= 0.12", 0.13, False),
        ("90 .. 99", 90.0, True),
        ("90 .. 99", 99.5, False),
        ("90 .. 99", 89.0, False),
        (">= 25", None, None),
    ],
)
def test_verdict(goal: str, measured: float | None, met: bool | None) -> None:
    row = Goal("a comparison", goal, measured)
    assert row.met is met
    assert row.plain() == {"id": "a comparison", "goal": goal, "measured": measured, "met": met}


@pytest.mark.parametrize("figure", [2, 3, 4, 5, 6])
def test_every_figure_with_data_has_an_experiment(figure: int) -> None:
    assert choose_experiments(figure, quick=True)


def test_a_robot_that_cannot_do_it_is_refused_before_anything_runs(
    write_robot: Callable[..., Path],
) -> None:
    experiments = choose_experiments(None, quick=True)
    robot = load_robot(write_robot(lambda document: document.pop("hardware")))
    with pytest.raises(RobotFileError, match="hardware"):
        check_cases(experiments, robot)

    def lower(document: Any) -> None:
        document["motions"]["squat"]["amplitude"] = [0.001, 0.04]

    robot = load_robot(write_robot(lower))
    with pytest.raises(InvalidValue, match="amplitude"):
        check_cases(experiments, robot)


def test_the_robot_of_the_paper_can_do_it(robot: Robot) -> None:
    for quick in (True, False):
        check_cases(choose_experiments(None, quick), robot)


def test_other_figures_are_refused() -> None:
    with pytest.raises(InvalidValue, match="one of 2, 3, 4, 5, 6"):
        choose_experiments(9, quick=True)


@pytest.mark.parametrize("quick", [True, False])
def test_first_jobs_have_unique_names_and_are_stable(quick: bool) -> None:
    jobs = [job for kind in EXPERIMENTS for job in kind(quick).jobs({})]
    again = [job for kind in EXPERIMENTS for job in kind(quick).jobs({})]
    names = [job.name for job in jobs]
    assert len(set(names)) == len(names)
    assert jobs == again


def test_millimeters() -> None:
    assert millimeters(0.0123456) == "12.346"
    assert millimeters(None) == "–"
