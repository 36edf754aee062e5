"""TSID's answers to the same task stacks, recorded by tests/recorded/record_tsid.py.

Where the formulations differ, and so what is not compared:

- TSID has no projection of the posture, so the posture's weight is zero here, and tasks
  and contacts determine all accelerations.
- Its soles carry forces at four corners, each in its own pyramid: friction of soles and their
  torsion are other sets there, and wide open in these cases. Points have the pyramid
  |f_x|, |f_y| <= mu f_z, ours has mu / sqrt(2). With the centre of pressure at an edge its
  corners leave less torsion: such ticks are not compared.
- Where contact rows follow from each other its solver refuses them as equalities. They are
  in its cost there, with a weight of 1e5, which lets feet accelerate by 1e-5 of what tasks lack.
- Rows that nearly follow from others, and so are held in part or not at all here, are
  equalities there, or in its cost with all their weight: such ticks are not compared.
"""

from __future__ import annotations

import json
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tsd_casadi import Controller, Robot, Status, Tick, compile_controller, load_robot
from tsd_casadi.motions.hold import hold
from tsd_casadi.state import State
from tsd_casadi.tick.row_state import RowState

TESTS = Path(__file__).parents[1]
FILES = {path.stem: path for path in TESTS.glob("robots/*/*.yaml")}
CASES = ("mini_biped", "five_joints", "mini_quadruped", "two_joints")
# of accelerations and forces, as shares of the largest
AGREEMENT = 1e-4


@cache
def recorded() -> dict[str, Any]:
    return dict(json.loads((TESTS / "recorded" / "tsid.json").read_text()))


def answer(robot: Robot, controller: Controller, case: dict[str, Any], asked: Any) -> Tick:
    weights, command = recorded()["weights"], controller.command()
    state = State(np.array(asked["q"]), np.zeros(robot.nv))
    hold(command, robot, state)
    mass, trunk = (
        robot.axis_for("", kind, axis).split(".")[0]
        for kind, axis in (("com", "x"), ("frame", "rx"))
    )
    command[f"{mass}.reference_acceleration"] = asked["com"]
    command[f"{trunk}.reference_acceleration"] = asked["turn"]
    command["posture.W"] = 0.0
    for contact in robot.description.contacts:
        weight = command[f"{contact.name}.W_lambda"]
        weight[:3], weight[3:] = weights["force"], weights["moment"]
    command["regularization.acceleration"] = weights["joints"]
    command["limits.torque"] = asked["limit"]
    command["limits.acceleration"] = 1e6
    command["limits.position_active"] = command["limits.velocity_active"] = 0.0
    for contact in robot.description.contacts:
        command[f"{contact.name}.maximum_force"] = 1e4
        command[f"{contact.name}.friction"] = case["friction"] * np.sqrt(2)
        if contact.type == "sole":
            command[f"{contact.name}.torsional_friction"] = 10.0
    return controller.tick(state, command)


@pytest.mark.parametrize("name", CASES)
def test_accelerations_and_forces_are_those_of_tsid(name: str) -> None:
    robot, case = load_robot(FILES[name]), recorded()["cases"][name]
    controller = compile_controller(robot, on_compile=lambda: None)
    assert case["joints"] == list(robot.joint_names)
    rows = slice(robot.nv, robot.nv + 6 + 6 * len(robot.feet))
    seen, worst = Counter[str](), {"qdd": 0.0, "forces": 0.0, "tau": 0.0}
    for asked in case["ticks"]:
        tick = answer(robot, controller, case, asked)
        expected = asked["answer"]
        if expected is None:
            # its torques are not enough either
            seen["refused"] += 1
            continue
        assert tick.status == Status.OK
        states = tick.reply[controller.format.reply.slice("active")][rows]
        dependent = bool((states == RowState.DEPENDENT).any())
        if dependent and not asked["alike"]:
            seen["nearly dependent"] += 1
            continue
        # what follows from others is what its solver refuses
        assert dependent == (asked["status"] != 0)
        if any("center_of_pressure" in row for row in tick.active):
            seen["at an edge"] += 1
            continue
        seen["dependent" if dependent else "independent"] += 1
        seen["at a limit"] += bool(tick.active)
        forces = [wrench[: len(f)] for wrench, f in zip(tick.wrenches.values(), expected["forces"])]  # noqa: B905
        for part, found, other in (
            ("qdd", tick.qdd, expected["qdd"]),
            ("forces", np.concatenate(forces), np.concatenate(expected["forces"])),
            ("tau", tick.tau, expected["tau"]),
        ):
            size = 1 + np.abs(other).max()
            worst[part] = max(worst[part], float(np.abs(found - np.array(other)).max() / size))
    print(name, dict(seen), worst)
    assert max(worst.values()) <= AGREEMENT
    assert seen["dependent"] + seen["independent"] > 10
