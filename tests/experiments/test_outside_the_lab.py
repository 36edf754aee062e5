"""Learning on a robot that shakes or changes: what the command counts, and its short form."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.squat import Squat
from tsd_casadi.motions.sway import Sway
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_casadi.repetition.learn import learn
from tsd_casadi.robot.robot import Robot
from tsd_experiments.beyond.outside_the_lab.budget import print_budget
from tsd_experiments.beyond.outside_the_lab.experiment import (
    ROWS,
    goals_of,
    jobs_of,
    repetitions_more,
)
from tsd_experiments.beyond.outside_the_lab.robots import FreshTorqueNoise, make_robot
from tsd_experiments.beyond.outside_the_lab.rows import (
    learn_through_change,
    learn_until_return,
    repeating_error,
)
from tsd_experiments.harness.learn_case import own_database


@pytest.mark.parametrize(
    ("errors", "sums", "more"),
    [
        ([10.0, 0.05, 0.04], [10.0, 0.07, 0.07], 0),
        ([10.0, 0.3, 0.04], [10.0, 0.07, 0.07], 1),
        ([10.0, 0.2, 0.04], [10.0, 0.4, 0.2], -1),
        # never: one more than there were
        ([10.0, 4.0, 4.0, 4.0, 4.0], [10.0, 0.07, 0.07, 0.07, 0.07], 4),
    ],
)
def test_repetitions_are_counted_against_the_plain_sum(
    errors: list[float], sums: list[float], more: int
) -> None:
    assert repetitions_more(errors, sums) == more


def test_every_row_has_its_runs_for_every_seed() -> None:
    jobs = jobs_of(ROWS, "hermes_lower", "adaptive", range(4, 7), 7)
    assert {job.seed for job in jobs} == {4, 5, 6}
    assert {job.row for job in jobs} == {*ROWS, "change/plain"}
    assert len({(job.row, job.seed) for job in jobs}) == len(jobs)


def measured(**changes: Any) -> dict[str, list[dict[str, Any]]]:
    noise = {"seed": 0, "refused": None, "after": 0.1, "floor": 0.1, "replay": 0.05}
    quiet = {"seed": 0, "errors": [17.0, *[0.03] * 9], "repetitions": 10, "alarms": 0}
    change = {"seed": 0, "errors": [10.0, 0.07, 0.05, 0.04, 0.04], "repetitions": 3, "alarms": 0}
    small = {"seed": 0, "errors": [1.0], "at_once": True, "repetitions": 5, "alarms": 0}
    rows = {"noise": {**noise, "repetitions": 6, "alarms": 0}, "quiet": quiet, "small": small}
    rows |= {"change": change, "change/plain": change}
    rows["return"] = {"seed": 0, "before": 0.03, "errors": [10.0, 0.03], "again": True}
    for name, change in changes.items():
        rows[name] = {**rows[name], **change}
    return {name: [row] for name, row in rows.items()}


def test_goals_are_met_where_all_is_well() -> None:
    assert all(goal.met for goal in goals_of(measured()))


@pytest.mark.parametrize(
    ("row", "change"),
    [
        ("noise", {"refused": "did not settle"}),
        ("noise", {"after": 0.2}),
        ("noise", {"replay": 0.13}),
        ("quiet", {"errors": [17.0, *[0.03] * 8, 0.05]}),
        ("change", {"errors": [10.0, 4.0, 4.0, 4.0, 4.0]}),
        ("small", {"at_once": False}),
        ("quiet", {"alarms": 1}),
        ("return", {"again": False}),
        ("return", {"errors": [10.0, 0.07]}),
    ],
)
def test_what_goes_wrong_misses_a_goal(row: str, change: dict[str, Any]) -> None:
    assert any(goal.met is False for goal in goals_of(measured(**{row: change})))


def test_what_was_not_run_is_not_covered() -> None:
    assert {goal.met for goal in goals_of({})} == {None}


def test_noise_is_another_one_in_each_run() -> None:
    noise = FreshTorqueNoise(1.0, seed=3)
    first = noise._rng.standard_normal(4)
    noise.reset()
    assert not np.array_equal(noise._rng.standard_normal(4), first)
    again = FreshTorqueNoise(1.0, seed=3)
    np.testing.assert_array_equal(again._rng.standard_normal(4), first)


@pytest.mark.long
@pytest.mark.parametrize(
    ("motion", "model_error", "noise", "gains"),
    [
        (Squat(0.03, 0.5), 0.1, 1.0, UNCHANGED),
        (Squat(0.03, 0.5, 0.055), -0.1, 0.0, Gains.critical(0.2)),
        (Sway(0.02, 0.5), 0.1, 0.0, UNCHANGED),
    ],
    ids=["1 N m of noise", "tall at P / 5", "sway"],
)
def test_what_only_scatters_is_learned_along_all_axes(
    robot: Robot, motion: Motion, model_error: float, noise: float, gains: Gains
) -> None:
    disturbances = [FreshTorqueNoise(noise)] if noise else []
    plant = make_robot(robot, model_error, disturbances=disturbances)
    with own_database() as database:
        first, second = learn(
            plant, compile_controller(robot), [motion], database, gains=gains, seed=[1, 2]
        )
    assert second.rank < 0.3 * first.rank


@pytest.mark.parametrize("noise", [0.0, 0.2, 2.0])
def test_what_repeats_is_told_from_what_does_not(noise: float) -> None:
    rng, phase = np.random.default_rng(0), np.linspace(0, 2 * np.pi, 100, endpoint=False)
    wave = 0.1 + 0.1 * np.sqrt(2) * np.sin(phase)  # mm
    laps = [
        Lap(phase, np.zeros((1, 100)), 1e-3 * (wave + noise * rng.standard_normal(100))[None, :])
        for _ in range(200)
    ]
    found = repeating_error(SimpleNamespace(laps=laps))  # type: ignore[arg-type]
    assert found == pytest.approx(0.1 * np.sqrt(2), rel=0.02 + 0.1 * noise)


def test_the_budget_is_printed_of_what_was_learned(capsys: pytest.CaptureFixture[str]) -> None:
    repeating = {"after": 0.023, "floor": 0.1, "replay": 0.12}
    row = {"refused": None, "after": 0.101, "floor": 0.15, "replay": 0.13, "repeating": repeating}
    print_budget([row, row, {"refused": "did not settle"}])
    told = capsys.readouterr().out
    assert "medians of 2 seeds" in told
    assert "0.101" in told
    assert "0.023" in told
    print_budget([{"refused": "did not settle"}])
    assert not capsys.readouterr().out


@pytest.mark.long
def test_what_was_learned_before_a_load_is_taken_again_when_it_goes() -> None:
    found = learn_until_return("hermes_lower", "adaptive", 0, 3, 3.0)
    assert found["again"]
    # 10 mm, and then what the best repetition before left
    assert found["errors"][0] > 20 * found["before"]
    assert found["errors"][1] < 1.2 * found["before"]


@pytest.mark.long
def test_a_load_is_noticed_and_learned_at_once() -> None:
    found = learn_through_change("hermes_lower", "adaptive", 0, 2, 0.1, 3.0)
    assert found["at_once"]
    assert found["alarms"] == 0
    # 10 mm, 0.25 mm, less than 0.1 mm
    assert found["errors"][1] < found["errors"][0] / 20
    assert found["errors"][2] < found["errors"][0] / 80
