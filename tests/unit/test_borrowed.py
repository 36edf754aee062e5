"""What was served is looked at again; what is borrowed is named, and gated."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tsd_casadi import Command, Feedforward, InverseDynamics, PeriodicBasis, Robot, Squat
from tsd_casadi.exceptions import IncompatibleEntry
from tsd_casadi.learning.bound import Bound
from tsd_casadi.repetition.borrowed import gates_for, name_borrowed
from tsd_casadi.repetition.check_served import ROUNDING, check_served
from tsd_casadi.repetition.gains import UNCHANGED, Gains

SQUAT = Squat(0.03, 0.5)
BASIS = PeriodicBasis()


@pytest.fixture
def controller(problem: InverseDynamics) -> Any:
    command = Command(problem.format.request)
    return SimpleNamespace(format=problem.format, command=command.copy)


@pytest.fixture
def own(robot: Robot) -> Feedforward:
    """What a learner serves of an entry that was learned in just this way."""
    weights = np.full((1, BASIS.L), 0.9)
    context = {
        "body": robot.body_fingerprint,
        "formulation": robot.formulation_fingerprint,
        "correction": "",
    }
    return Feedforward(
        ("com.z",),
        BASIS,
        weights,
        np.zeros_like(weights),
        "learned",
        parameters=SQUAT.parameters,
        provenance={
            "robot": robot.name,
            "entries": [4],
            "context": context,
            "gains": {"P": [50.0]},
        },
        bound=Bound((0.9,), "1.5 times what was recorded"),
    )


def told(feedforward: Feedforward, **changes: Any) -> Feedforward:
    """The same, but its learner says something else."""
    provenance: dict[str, Any] = {**feedforward.provenance}
    for name, value in changes.items():
        if name in ("body", "formulation", "correction"):
            provenance["context"] = {**provenance["context"], name: value}
        else:
            provenance[name] = value
    return replace(feedforward, provenance=provenance)


def test_what_is_the_robots_own_passes_without_a_gate(
    own: Feedforward, robot: Robot, controller: Any
) -> None:
    check_served(own, robot, SQUAT)
    assert name_borrowed(own, SQUAT, controller, UNCHANGED, "") is None
    assert gates_for(own, robot, controller, SQUAT, UNCHANGED, "") == []
    assert gates_for(None, robot, controller, SQUAT, UNCHANGED, "") == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"robot": "g1"}, r"another robot, g1; the robot that would move has hermes_lower"),
        ({"body": "abc"}, r"another body, abc"),
        ({"formulation": "abc"}, r"another formulation, abc"),
    ],
)
def test_what_is_not_for_the_robot_is_refused_by_name(
    own: Feedforward, robot: Robot, controller: Any, changes: dict[str, Any], words: str
) -> None:
    with pytest.raises(IncompatibleEntry, match=words):
        gates_for(told(own, **changes), robot, controller, SQUAT, UNCHANGED, "")


def test_axes_and_numbers_are_looked_at(own: Feedforward, robot: Robot) -> None:
    with pytest.raises(IncompatibleEntry, match=r"along hand\.q, which hermes_lower does not"):
        check_served(replace(own, axes=("hand.q",)), robot, SQUAT)
    with pytest.raises(IncompatibleEntry, match="reaches nan"):
        check_served(replace(own, weights=np.nan * own.weights), robot, SQUAT)
    beyond = replace(own, bound=Bound((0.9 / (1 + 2 * ROUNDING),), "what was recorded"))
    with pytest.raises(IncompatibleEntry, match=r"reaches 0\.9 .* along com\.z.*what was recorded"):
        check_served(beyond, robot, SQUAT)
    # 54 m/s^2 is what the torque limits leave
    strong = replace(own, bound=Bound((98.0,), "said"), weights=70 * own.weights)
    with pytest.raises(IncompatibleEntry, match=r"reaches 63 .*, what the torque limits allow"):
        check_served(strong, robot, SQUAT)
    absurd = replace(own, bound=None, weights=120 * own.weights)
    with pytest.raises(IncompatibleEntry, match=r"more than .*, what a robot's task may do"):
        check_served(absurd, robot, SQUAT)


def test_what_is_looked_at_over_other_axes_is_bounded_along_each(
    own: Feedforward, robot: Robot
) -> None:
    more = own.over(("com.x", "com.z"))
    check_served(more, robot, SQUAT)
    weights = more.weights.copy()
    weights[0] = 0.1
    with pytest.raises(IncompatibleEntry, match=r"reaches 0\.1 .* along com\.x, more than 0"):
        check_served(replace(more, weights=weights), robot, SQUAT)


def test_rounding_and_what_nobody_wrote_down_are_not_held_against_it(
    own: Feedforward, robot: Robot
) -> None:
    check_served(replace(own, bound=Bound((0.9 / (1 + 0.5 * ROUNDING),), "")), robot, SQUAT)
    check_served(told(own, body="", formulation=""), robot, SQUAT)
    check_served(replace(own, provenance={}), robot, SQUAT)


@pytest.mark.parametrize(
    ("changes", "gains", "correction", "words"),
    [
        ({}, Gains.critical(0.2), "", "learned at P = 50, used at 10"),
        ({"gains": {"P": [50.0], "D": [10.0]}}, UNCHANGED, "", "learned at D = 10, used at 14"),
        ({"gains": {"P": [50.0, 50.0]}}, UNCHANGED, "", "learned at P = 50, used at 50"),
        ({}, UNCHANGED, "c0ffee123", "the model's own, used with the corrected"),
        ({"correction": "c0ffee123"}, UNCHANGED, "", "centre of mass c0ffee, used with the model"),
        ({"body": ""}, UNCHANGED, "", "nobody wrote down"),
    ],
)
def test_what_is_borrowed_is_named_and_gated(
    own: Feedforward,
    robot: Robot,
    controller: Any,
    changes: dict[str, Any],
    gains: Gains,
    correction: str,
    words: str,
) -> None:
    served = told(own, **changes)
    name = name_borrowed(served, SQUAT, controller, gains, correction)
    assert name is not None
    assert words in name
    (gate,) = gates_for(served, robot, controller, SQUAT, gains, correction)
    assert gate.name == name


def test_other_parameters_and_kinds_are_borrowed(own: Feedforward, controller: Any) -> None:
    elsewhere = name_borrowed(own, Squat(0.05, 0.5), controller, UNCHANGED, "")
    assert elsewhere == "the feedforward learned for amplitude 0.03"
    generalized = replace(own, kind="generalised")
    named = name_borrowed(told(generalized, entries=[1, 2]), SQUAT, controller, UNCHANGED, "")
    assert named == "the feedforward generalised from entries 1, 2"
    robots = [{"model_error": 0.1}, {"model_error": 0.2}]
    mixed = told(generalized, entries=[1, 2], hardware=robots)
    named = name_borrowed(mixed, SQUAT, controller, UNCHANGED, "")
    assert named is not None
    assert named.endswith("entries 1, 2, learned on robots that differ (model_error 0.1 or 0.2)")
    each = told(generalized, entries=[1, 2], gains=[{"P": [50.0]}, {"P": [20.0]}, {}])
    named = name_borrowed(each, SQUAT, controller, UNCHANGED, "")
    assert named is not None
    assert named.endswith("from entries 1, 2, learned at P = 20, used at 50")
