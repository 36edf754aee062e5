"""Public objects say in one line what they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tsd_casadi import (
    Controller,
    Database,
    Feedforward,
    InverseDynamics,
    PeriodicBasis,
    Robot,
    Run,
    Squat,
)


@pytest.fixture
def feedforward() -> Feedforward:
    zero = Feedforward.zero(("com.z",), PeriodicBasis())
    return replace(
        zero,
        weights=zero.weights - 0.75,
        kind="learned",
        parameters={"amplitude": 0.03},
        provenance={"iteration": 2},
    )


def a_run(feedforward: Feedforward, **changes: Any) -> Run:
    values: dict[str, Any] = {
        "robot": "hermes_lower",
        "motion": Squat(0.03, 0.25),
        "axes": ("com.z",),
        "feedforward": feedforward,
        "gains": {},
        "settings": {},
        "log": {
            "time": np.arange(2.0),
            **{name: np.full((2, 1), 1.5e-3) for name in ("error", "true_error", "feedback")},
            "measured": np.ones(2, dtype=bool),
        },
        "laps": [],
        "laps_run": 3,
        "steady": True,
        "fell": False,
        "vetoes": [],
        "failures": {},
    }
    return Run(**{**values, **changes})


def test_what_a_robot_and_its_controller_are(
    robot: Robot, controller: Controller, problem: InverseDynamics
) -> None:
    assert repr(robot) == (
        "<Robot hermes_lower: 17 joints; contacts left_foot, right_foot; tasks com, pelvis, torso>"
    )
    request, reply = problem.format.request, problem.format.reply
    sizes = (
        f"hermes_lower: 17 joints, 80 rows, request of {request.size} and reply of {reply.size} "
        "float64"
    )
    assert repr(controller) == f"<Controller of {sizes}>"
    assert repr(controller.format) == f"<TickFormat of {sizes}>"
    assert repr(problem) == (
        "<InverseDynamics of hermes_lower: 35 variables, 80 rows, 18 of them equalities; tasks "
        "com, pelvis, torso>"
    )
    assert repr(robot.home) == "<State: base at 0.000 0.000 0.709 m, 17 joints, |v| 0>"


def test_what_goes_in_and_out_at_a_tick(robot: Robot, controller: Controller) -> None:
    command = controller.command()
    sizes = f"{command.request.size} float64 in {len(command.fields)} fields"
    assert repr(command) == f"<Command: {sizes}, see .fields>"
    text = repr(controller.tick(robot.home, command))
    assert text.startswith("<Tick of hermes_lower: ok, torques up to ")
    assert " N m, 0 rows active, " in text


def test_what_was_done_and_learned(feedforward: Feedforward, tmp_path: Path) -> None:
    assert repr(feedforward) == (
        "<Feedforward along com.z: learned, iteration 2 amplitude=0.03; weights up to 0.75 m/s^2>"
    )
    what = "<Run of hermes_lower: squat amplitude=0.03 frequency=0.25 height=0; feedforward "
    assert repr(a_run(feedforward)) == f"{what}learned, iteration 2; com.z 1.5000 mm>"
    none = Feedforward.zero(("com.z",), PeriodicBasis())
    assert repr(a_run(none, steady=False)) == f"{what}none; com.z 1.5000 mm, never steady>"
    assert repr(a_run(none, fell=True)) == f"{what}none; fell after 2 ticks>"
    with Database(tmp_path / "d.sqlite") as database:
        assert repr(database) == f"<Database {tmp_path / 'd.sqlite'}>"


def test_a_command_lists_what_can_be_set(controller: Controller) -> None:
    command = controller.command()
    fields = command.fields
    assert list(fields)[:3] == ["q", "v", "com.reference"]
    assert (fields["com.P"].size, fields["com.P"].unit) == (3, "1/s^2")
    for name, field in fields.items():
        assert command[name].shape == (field.size,)
