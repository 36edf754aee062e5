from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest
import yaml

from tsd_casadi import (
    Command,
    Controller,
    InverseDynamics,
    Robot,
    Status,
    compile_controller,
    load_robot,
)
from tsd_casadi.compilation.code_generation import generate_sources
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.formulation.dependent_rows import sort_rows
from tsd_casadi.robot.checks import FLATNESS
from tsd_casadi.robot.foot import feet_jacobian

Write = Callable[[Callable[[Any], object]], Path]


@pytest.fixture(scope="module")
def quadruped(mini_quadruped: Robot) -> InverseDynamics:
    return InverseDynamics(mini_quadruped)


@pytest.fixture(scope="module")
def mixed(peg_leg: Robot) -> InverseDynamics:
    return InverseDynamics(peg_leg)


@pytest.fixture(scope="module")
def controller(mini_quadruped: Robot) -> Controller:
    return compile_controller(mini_quadruped, on_compile=lambda: None)


@pytest.fixture
def write_quadruped(mini_quadruped: Robot, tmp_path: Path) -> Write:
    folder = tmp_path / "mini_quadruped"
    shutil.copytree(mini_quadruped.path.parent, folder)
    path = folder / mini_quadruped.path.name

    def write(edit: Callable[[Any], object]) -> Path:
        document = yaml.safe_load(path.read_text())
        edit(document)
        path.write_text(yaml.safe_dump(document))
        return path

    return write


# layouts and rows


def test_a_point_has_three_of_each_and_no_sole(quadruped: InverseDynamics) -> None:
    fields = {
        f.name.removeprefix("fl_ground."): f for f in quadruped.request if "fl_ground" in f.name
    }
    assert {name: field.size for name, field in fields.items()} == {
        "active": 1,
        "friction": 1,
        "minimum_force": 1,
        "maximum_force": 1,
        "lambda_des": 3,
        "W_lambda": 3,
    }
    assert (fields["lambda_des"].unit, fields["W_lambda"].unit) == ("N", "1/N^2")
    assert fields["lambda_des"].description == (
        "wanted force while all contacts have active = 1, world axes"
    )
    rows = [name for name in quadruped.row_names if name.startswith("fl_ground.")]
    assert rows == [
        *(f"fl_ground.acceleration.{axis}" for axis in "xyz"),
        *(f"fl_ground.friction.{face}" for face in ("-x", "+x", "-y", "+y")),
        "fl_ground.unilateral_force",
    ]


def test_variables_and_rows_are_counted_by_kind(
    quadruped: InverseDynamics, mixed: InverseDynamics
) -> None:
    assert (quadruped.nx, quadruped.n_equalities) == (18 + 4 * 3, 6 + 4 * 3)
    assert (mixed.nx, mixed.n_equalities) == (18 + 3 + 6, 6 + 3 + 6)


def test_defaults_of_a_point_share_the_weight(
    quadruped: InverseDynamics, mini_quadruped: Robot
) -> None:
    command = Command(quadruped.request)
    for contact in mini_quadruped.description.contacts:
        share = mini_quadruped.weight / 4
        np.testing.assert_allclose(command[f"{contact.name}.lambda_des"], [0, 0, share])
        np.testing.assert_array_equal(command[f"{contact.name}.W_lambda"], [1e-6] * 3)


def test_the_reply_keeps_six_numbers_for_each_contact(
    quadruped: InverseDynamics, mixed: InverseDynamics
) -> None:
    for problem, contacts, words in (
        (quadruped, 4, "world axes, moments zero, of fl_ground fr_ground rl_ground rr_ground;"),
        (mixed, 2, "world axes, moments zero, of far_tip, in the sole frames of near_ground;"),
    ):
        field = next(field for field in problem.format.reply if field.name == "wrenches")
        assert field.size == 6 * contacts
        assert f"[force; moment] in {words} zero on failure" == field.description


def test_the_compiled_code_knows_where_forces_go(mixed: InverseDynamics) -> None:
    header = generate_sources(mixed)["problem.h"]
    found = re.search(r"force_places\[\] = \{([\d, ]+)\};", header)
    assert found is not None
    # one more, because C has no empty arrays
    assert [int(place) for place in found[1].split(",")][:-1] == [0, 1, 2, 6, 7, 8, 9, 10, 11]


def test_points_and_soles_are_different_formulations(peg_leg: Robot, tmp_path: Path) -> None:
    folder = shutil.copytree(peg_leg.path.parent, tmp_path / "biped")
    path = Path(folder) / peg_leg.path.name
    document = yaml.safe_load(path.read_text())
    contact = document["contacts"][0]
    contact |= {"type": "sole", "x": [-0.1, 0.1], "y": [-0.1, 0.1], "torsional_friction": 0.1}
    path.write_text(yaml.safe_dump(document))
    flat = load_robot(path)
    assert flat.formulation_fingerprint != peg_leg.formulation_fingerprint
    assert flat.body_fingerprint == peg_leg.body_fingerprint


# the compiled controller


def test_a_failed_tick_has_no_forces_and_a_safe_torque(
    controller: Controller, mini_quadruped: Robot
) -> None:
    command = controller.command()
    command["fl_ground.minimum_force"] = 1e6
    tick = controller.tick(mini_quadruped.home, command)
    assert tick.status == Status.INFEASIBLE
    assert not any(wrench.any() for wrench in tick.wrenches.values())
    assert tick.active == []
    # the error behind the wrenches in the reply is still told
    assert tick.error.shape == (6,)
    np.testing.assert_allclose(tick.error, 0, atol=1e-9)


@pytest.mark.parametrize("off", [None, "fl_ground"])
def test_the_safe_torque_holds_a_stance_on_points(
    off: str | None, controller: Controller, mini_quadruped: Robot
) -> None:
    robot, command = mini_quadruped, controller.command()
    feet = [foot for foot in robot.feet if foot.name != off]
    if off is not None:
        command[f"{off}.active"] = 0.0
    command["level.W"] = -1e3
    tick = controller.tick(robot.home, command)
    assert tick.status == Status.SINGULAR
    model, data = robot.model, robot.model.createData()
    M = np.triu(pinocchio.crba(model, data, robot.home.q))
    M = M + np.triu(M, 1).T
    J = feet_jacobian(feet, model, data, robot.home.q)
    kkt = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    force = np.concatenate((np.zeros(6), tick.tau))
    force -= pinocchio.computeGeneralizedGravity(model, data, robot.home.q)
    qdd = np.linalg.solve(kkt, np.concatenate((force, np.zeros(len(J)))))[: robot.nv]
    assert np.abs(qdd).max() < 1e-2


def test_a_turned_robots_forces_stay_in_world_axes(
    controller: Controller, mini_quadruped: Robot
) -> None:
    # turned about the vertical with all that it is asked for: forces turn with it
    command = controller.command()
    command["mass.reference_acceleration"] = [0.5, 0.2, 0.1]
    before = controller.tick(mini_quadruped.home, command)
    turn = pinocchio.exp3(np.array([0.0, 0.0, 0.7]))
    q = mini_quadruped.home.q.copy()
    q[:3], q[3:7] = turn @ q[:3], pinocchio.Quaternion(turn).coeffs()
    command["mass.reference"] = turn @ command["mass.reference"]
    command["mass.reference_acceleration"] = turn @ [0.5, 0.2, 0.1]
    command["level.reference"][:3] = turn @ command["level.reference"][:3]
    command["level.reference"][3:] = q[3:7]
    command["q"] = q
    after = controller.run(command.request)
    tau = after[controller.format.reply.slice("tau")]
    wrenches = after[controller.format.reply.slice("wrenches")].reshape(-1, 6)
    np.testing.assert_allclose(tau, before.tau, atol=1e-7)
    for found, wrench in zip(wrenches, before.wrenches.values(), strict=True):
        np.testing.assert_allclose(found[:3], turn @ wrench[:3], atol=1e-6)
        assert abs(found[0] - wrench[0]) > 1e-2


# what is refused


def error_of(path: Path) -> RobotFileError:
    with pytest.raises(RobotFileError) as caught:
        load_robot(path)
    return caught.value


def test_a_point_has_to_touch_the_ground(write_quadruped: Write) -> None:
    error = error_of(write_quadruped(lambda d: d["home"].update(fl_bend=-1.35)))
    assert error.field == "home"
    assert re.search(r"leaves \w+_ground [\d.]+ mm above \w+_ground", str(error))
    assert "all points on one plane" in error.expected


@pytest.mark.parametrize("angle", [-1.404, -1.396])
def test_a_millimetre_is_level_enough(angle: float, write_quadruped: Write) -> None:
    robot = load_robot(write_quadruped(lambda d: d["home"].update(fl_bend=angle)))
    heights = [place.translation[2] for place in robot.sole_placements(robot.home.q)]
    assert 2e-4 < max(np.abs(heights)) < FLATNESS


def test_a_points_link_may_be_turned(write_quadruped: Write) -> None:
    # all legs bent alike: no foot's frame is upright any more
    def crouch(document: Any) -> None:
        for leg in ("fl", "fr", "rl", "rr"):
            document["home"] |= {f"{leg}_lift": 0.8, f"{leg}_bend": -1.6}

    robot = load_robot(write_quadruped(crouch))
    tilts = [1 - place.rotation[2, 2] for place in robot.sole_placements(robot.home.q)]
    assert min(tilts) > 1e-3


@pytest.mark.parametrize("feet", [1, 2])
def test_points_on_a_line_are_nothing_to_stand_on(feet: int, write_quadruped: Write) -> None:
    error = error_of(write_quadruped(lambda d: d.update(contacts=d["contacts"][:feet])))
    assert error.field == "contacts"
    assert "along a line" in str(error)
    assert "three points" in error.expected


def test_three_points_are_enough(write_quadruped: Write) -> None:
    robot = load_robot(write_quadruped(lambda d: d.update(contacts=d["contacts"][:3])))
    assert len(robot.feet) == 3


def test_points_that_depend_on_each_other_are_found(write_quadruped: Write) -> None:
    def twice(document: Any) -> None:
        document["contacts"].append({**document["contacts"][0], "name": "again"})

    problem = InverseDynamics(load_robot(write_quadruped(twice)))
    program = problem.evaluate(Command(problem.request).request)
    nv, end = problem.nv, problem.nv + problem.n_equalities
    rows = sort_rows(program.A[: problem.n_equalities], program.lower[nv:end])
    left_out = [problem.row_names[nv + row] for row in rows.left_out]
    assert left_out == [f"again.acceleration.{axis}" for axis in "xyz"]
    assert rows.partly == ()


@pytest.mark.parametrize("field", ["x", "y", "torsional_friction"])
def test_a_point_has_no_extent(field: str, write_quadruped: Write) -> None:
    error = error_of(write_quadruped(lambda d: d["contacts"][1].update({field: 0.1})))
    assert error.field == f"contacts.1.{field}"
    assert "not a known field" in str(error)
