from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi import InverseDynamics, Robot, Status, Tick, load_robot
from tsd_casadi.exceptions import UnknownField
from tsd_casadi.tick.format import STATUS_MEANING, TickFormat


@pytest.fixture(scope="module")
def tick_format(problem: InverseDynamics) -> TickFormat:
    return problem.format


def test_names_follow_the_robot(tick_format: TickFormat, robot: Robot) -> None:
    assert tick_format.robot == robot.name
    assert tick_format.joints == tuple(robot.joint_names)
    assert tick_format.contacts == ("left_foot", "right_foot")


def test_axes_follow_the_tasks(tick_format: TickFormat, robot: Robot) -> None:
    assert tick_format.axes == tuple(
        (task.name, axis) for task in robot.description.tasks for axis in task.axes
    )
    assert tick_format.axis_index("com", "z") == 2
    assert tick_format.axis_index("pelvis", "rx") == 3
    assert tick_format.axis_index("torso", "rz") == 8


def test_component_index_counts_inside_a_task(tick_format: TickFormat) -> None:
    assert tick_format.component_index("com", "z") == 2
    assert tick_format.component_index("pelvis", "rx") == 0
    assert tick_format.component_index("torso", "rz") == 2


@pytest.mark.parametrize(("task", "axis"), [("com", "rx"), ("pelvis", "z"), ("feet", "z")])
def test_unknown_axis_lists_the_known_ones(task: str, axis: str, tick_format: TickFormat) -> None:
    for index in (tick_format.axis_index, tick_format.component_index):
        with pytest.raises(UnknownField, match=rf"{task}\.{axis}") as caught:
            index(task, axis)
        assert "com.z" in caught.value.known


def test_request_starts_with_the_state_and_every_field_is_described(
    tick_format: TickFormat, robot: Robot
) -> None:
    fields = list(tick_format.request)
    assert [(f.name, f.size) for f in fields[:2]] == [("q", robot.nq), ("v", robot.nv)]
    for field in fields:
        assert len(field.default) == field.size, field.name
        assert field.description, field.name
        assert field.unit, field.name
        assert field.lower <= min(field.default) <= max(field.default) <= field.upper, field.name
    assert len({field.name for field in fields}) == len(fields)


def test_switches_and_quaternions_of_the_request(tick_format: TickFormat) -> None:
    layout = tick_format.request
    switches = [layout.locate(index)[0].name for index in layout.switches()]
    assert switches == [
        "limits.velocity_active",
        "limits.position_active",
        "explain",
    ]
    quaternions = [layout.locate(index) for index in layout.quaternions()]
    assert [(field.name, position) for field, position in quaternions] == [
        ("q", 3),
        ("pelvis.reference", 3),
        ("torso.reference", 3),
    ]


def test_everything_a_user_may_change_is_in_the_request(tick_format: TickFormat) -> None:
    names = {field.name for field in tick_format.request}
    per_task = ("reference", "reference_velocity", "reference_acceleration", "feedforward")
    per_task += ("P", "P_coupling", "D", "D_coupling", "W", "active", "mask")
    per_contact = ("active", "friction", "torsional_friction", "extents", "minimum_force")
    per_contact += ("maximum_force", "lambda_des", "W_lambda")
    assert names == {
        "q",
        "v",
        *(f"{task}.{part}" for task in ("com", "pelvis", "torso") for part in per_task),
        *(f"{foot}_foot.{part}" for foot in ("left", "right") for part in per_contact),
        *(f"posture.{part}" for part in ("q_ref", "P", "D", "W")),
        "regularization.acceleration",
        *(f"limits.{part}" for part in ("torque", "acceleration", "velocity", "braking")),
        *(f"limits.position_{end}" for end in ("lower", "upper")),
        *(f"limits.{part}" for part in ("stall_torque", "no_load_speed")),
        *(f"limits.{quantity}_active" for quantity in ("velocity", "position")),
        "period",
        "explain",
        "safe_torque.D",
    }


def test_sizes_of_the_reply(tick_format: TickFormat, robot: Robot) -> None:
    sizes = {field.name: field.size for field in tick_format.reply}
    assert sizes == {
        "status": 1,
        "iterations": 1,
        "data_time": 1,
        "factorization_time": 1,
        "solve_time": 1,
        "tau": robot.n,
        "qdd": robot.nv,
        "wrenches": 12,
        "error": 9,
        "feedback": 9,
        "active": len(tick_format.row_names),
        "conflict": len(tick_format.row_names),
    }


def test_every_status_has_a_meaning() -> None:
    assert set(STATUS_MEANING) == set(Status)
    assert [int(status) for status in Status] == [0, 1, 2, 3, 4]


def test_a_reply_is_read_by_name(tick_format: TickFormat, robot: Robot) -> None:
    layout = tick_format.reply
    reply = np.arange(layout.size, dtype=float)
    reply[0] = Status.SINGULAR
    active = np.zeros(len(tick_format.row_names))
    active[[2, 30, 70]] = [1.0, 2.0, -1.0]
    reply[layout.slice("active")] = active
    tick = Tick(tick_format, reply)
    assert tick.status is Status.SINGULAR
    assert tick.iterations == 1
    assert tick.compute_time == 2 + 3 + 4
    for name in ("tau", "qdd", "error", "feedback"):
        np.testing.assert_array_equal(getattr(tick, name), reply[layout.slice(name)])
    both = np.concatenate((tick.wrenches["left_foot"], tick.wrenches["right_foot"]))
    np.testing.assert_array_equal(both, reply[layout.slice("wrenches")])
    assert tick.active == [tick_format.row_names[2], tick_format.row_names[70]]


def test_hash_is_that_of_the_formulation_and_not_of_the_gains(
    tick_format: TickFormat, robot: Robot
) -> None:
    assert InverseDynamics(load_robot(robot.path)).format.layout_hash == tick_format.layout_hash
    assert 0 < tick_format.layout_hash < 2**64
