from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tsd_casadi import Command, Controller, Robot, State, Status, Tick, load_robot
from tsd_casadi.exceptions import InvalidValue, NotLoadable
from tsd_casadi.tick.layout import Field

Edit = Callable[[Command], object]
TIMES = ("data_time", "factorization_time", "solve_time")


def put(**fields: Any) -> Edit:
    def edit(command: Command) -> None:
        for name, value in fields.items():
            command[name.replace("__", ".")] = value

    return edit


# everything that makes a solve fail, and how
FAILURES: dict[str, tuple[Edit, Status]] = {
    "more force than the legs have": (put(left_foot__minimum_force=1e6), Status.INFEASIBLE),
    "sole inside out": (put(left_foot__extents=[0.1, -0.1, 0.05, -0.05]), Status.INFEASIBLE),
    "no torque": (put(limits__torque=0.0), Status.INFEASIBLE),
    "negative weight": (put(com__W=-10.0), Status.SINGULAR),
    "no weight on wrenches": (
        put(left_foot__W_lambda=0.0, right_foot__W_lambda=0.0),
        Status.SINGULAR,
    ),
    "no weight at all": (
        put(
            com__active=0.0,
            pelvis__active=0.0,
            torso__active=0.0,
            posture__W=0.0,
            regularization__acceleration=0.0,
        ),
        Status.SINGULAR,
    ),
}


HOME = load_robot("hermes_lower").home


def run(controller: Controller, edit: Edit, state: State | None = None) -> Tick:
    command = controller.command()
    edit(command)
    return controller.tick(state or HOME, command)


def lasting(tick: Tick) -> bytes:
    reply = tick.reply.copy()
    for name in TIMES:
        reply[tick.format.reply.slice(name)] = 0.0
    return reply.tobytes()


def moving(robot: Robot, seed: int) -> State:
    rng = np.random.default_rng(seed)
    q = robot.home.q.copy()
    q[3:7] = Rotation.from_rotvec(rng.normal(scale=0.1, size=3)).as_quat()
    q[7:] += rng.normal(scale=0.1, size=robot.n)
    return State(q, rng.normal(scale=0.3, size=robot.nv))


def test_same_request_gives_the_same_bits_whatever_came_before(
    controller: Controller, robot: Robot
) -> None:
    states = [robot.home, moving(robot, 0), moving(robot, 1)]

    def tick(state: State, friction: float) -> Tick:
        return run(controller, put(left_foot__friction=friction), state)

    first = [lasting(tick(state, mu)) for state in states for mu in (0.5, 0.1)]
    for failing, _ in FAILURES.values():
        run(controller, failing)
        again = [lasting(tick(state, mu)) for state in states for mu in (0.5, 0.1)]
        assert again == first
    with pytest.raises(InvalidValue):
        run(controller, put(com__P=np.nan))
    assert lasting(tick(states[1], 0.1)) == first[3]


def test_two_controllers_of_one_library_do_not_share_memory(
    controller: Controller, robot: Robot
) -> None:
    other = Controller(controller.format, controller.library)
    state = moving(robot, 2)
    expected = run(controller, put(), state)
    run(other, FAILURES["negative weight"][0])
    assert lasting(run(other, put(), state)) == lasting(expected)
    del other
    assert lasting(run(controller, put(), state)) == lasting(expected)


def test_an_earlier_reply_is_not_overwritten(controller: Controller, robot: Robot) -> None:
    tick = run(controller, put())
    before = tick.reply.copy()
    run(controller, FAILURES["no torque"][0], moving(robot, 3))
    np.testing.assert_array_equal(tick.reply, before)


@pytest.mark.parametrize("case", FAILURES)
@pytest.mark.parametrize("seed", [None, 4])
def test_failures_have_their_status_and_a_safe_torque(
    case: str, seed: int | None, controller: Controller, robot: Robot
) -> None:
    edit, status = FAILURES[case]
    state = robot.home if seed is None else moving(robot, seed)
    command = controller.command()
    edit(command)
    tick = controller.tick(state, command)
    assert tick.status == status
    assert not tick.qdd.any()
    assert not any(wrench.any() for wrench in tick.wrenches.values())
    assert tick.active == []
    assert (np.abs(tick.tau) <= command["limits.torque"]).all()
    np.testing.assert_allclose(tick.tau, safe_torque(robot, state, command), atol=1e-2)
    good = run(controller, put(), state)
    np.testing.assert_array_equal(tick.error, good.error)


def safe_torque(robot: Robot, state: State, command: Command) -> np.ndarray:
    model, data = robot.model, robot.model.createData()
    gravity = pinocchio.computeGeneralizedGravity(model, data, state.q)
    tau = gravity[6:] - command["safe_torque.D"] * state.v[6:]
    J = contact_jacobian(robot, state, command)
    if len(J):
        tau = tau - J[:, 6:].T @ np.linalg.pinv(J[:, :6].T) @ gravity[:6]
    return np.asarray(np.clip(tau, -command["limits.torque"], command["limits.torque"]))


def contact_jacobian(robot: Robot, state: State, command: Command) -> np.ndarray:
    J = [
        pinocchio.computeFrameJacobian(
            robot.model,
            robot.model.createData(),
            state.q,
            robot.model.getFrameId(contact.frame),
            pinocchio.LOCAL,
        )
        for contact in robot.description.contacts
        if command[f"{contact.name}.active"][0]
    ]
    return np.vstack(J) if J else np.zeros((0, robot.nv))


@pytest.mark.parametrize("feet", [(1, 1), (1, 0), (0, 1), (0, 0)])
@pytest.mark.parametrize("seed", range(3))
def test_safe_torque_is_gravity_compensation_and_damping(
    feet: tuple[int, int], seed: int, controller: Controller, robot: Robot
) -> None:
    state, command = moving(robot, seed), controller.command()
    put(left_foot__active=feet[0], right_foot__active=feet[1], pelvis__W=-1e3)(command)
    command["safe_torque.D"] = np.linspace(0, 20, robot.n)
    tick = controller.tick(state, command)
    assert tick.status == Status.SINGULAR
    expected = safe_torque(robot, state, command)
    np.testing.assert_allclose(tick.tau, expected, rtol=0, atol=1e-4 * (1 + abs(expected).max()))


@pytest.mark.parametrize("feet", [(1, 1), (1, 0)])
def test_safe_torque_holds_a_static_stance(
    feet: tuple[int, int], controller: Controller, robot: Robot
) -> None:
    command, state = controller.command(), robot.home
    put(left_foot__active=feet[0], right_foot__active=feet[1], pelvis__W=-1e3)(command)
    tick = controller.tick(state, command)
    assert tick.status == Status.SINGULAR
    model, data = robot.model, robot.model.createData()
    M = np.triu(pinocchio.crba(model, data, state.q))
    M = M + np.triu(M, 1).T
    J = contact_jacobian(robot, state, command)
    kkt = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    force = np.concatenate((np.zeros(6), tick.tau))
    force -= pinocchio.computeGeneralizedGravity(model, data, state.q)
    qdd = np.linalg.solve(kkt, np.concatenate((force, np.zeros(len(J)))))[: robot.nv]
    assert np.abs(qdd).max() < 1e-2


def test_safe_torque_is_clipped_joint_by_joint(controller: Controller, robot: Robot) -> None:
    limits = np.linspace(1.0, 60.0, robot.n)
    tick = run(controller, put(limits__torque=limits, pelvis__W=-1e3))
    assert tick.status == Status.SINGULAR
    free = run(controller, put(pelvis__W=-1e3)).tau
    np.testing.assert_allclose(tick.tau, np.clip(free, -limits, limits), atol=1e-9)
    assert (np.abs(free) > limits).any()


@pytest.mark.parametrize("part", [slice(0, 3), slice(7, None)], ids=["base", "joints"])
def test_a_solution_that_rounding_spoilt_is_told(
    part: slice, controller: Controller, robot: Robot
) -> None:
    q = robot.home.q.copy()
    q[part] = 1e9
    velocity = np.full(robot.nv, 0.3)
    command = controller.command()
    # joints that far outside their limits would have them yield, which is another solution
    command["limits.position_active"] = command["limits.velocity_active"] = 0.0
    tick = controller.tick(State(q, velocity), command)
    assert tick.status == Status.ITERATION_LIMIT
    assert tick.iterations > 0
    assert np.isfinite(tick.reply).all()
    assert (np.abs(tick.tau) <= robot.torque_limit).all()
    assert not tick.qdd.any()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_no_number_may_be_missing(value: float, controller: Controller, robot: Robot) -> None:
    request = controller.command().request
    for index in range(request.size):
        broken = request.copy()
        broken[index] = value
        field, position = controller.format.request.locate(index)
        with pytest.raises(InvalidValue) as caught:
            controller.run(broken)
        expected = field.name if field.size == 1 else f"{field.name}[{position}]"
        assert caught.value.field == expected
        assert str(caught.value).startswith(f"{expected} is {value}")


@pytest.mark.parametrize(
    ("edit", "field", "expected"),
    [
        (put(com__P=-1.0), "com.P[0]", "a finite number from 0 to 1e+09, 1/s^2"),
        (put(com__P=[1.0, 2.0, 1.1e9]), "com.P[2]", "from 0 to 1e+09"),
        (put(posture__q_ref=-2e9), "posture.q_ref[0]", "from -1e+09 to 1e+09, rad"),
        (put(limits__torque=-1e-9), "limits.torque[0]", "from 0 to 1e+09, N m"),
        (put(left_foot__friction=-0.1), "left_foot.friction", "from 0"),
        (put(limits__position_active=0.5), "limits.position_active", "0 or 1"),
        (put(right_foot__active=-1.0), "right_foot.active", "from 0 to 1"),
        (put(left_foot__active=2.0), "left_foot.active", "from 0 to 1"),
        (put(left_foot__active=1e10), "left_foot.active", "from 0 to 1"),
        (put(pelvis__reference=0.0), "the norm of the quaternion in pelvis.reference", "x y z w"),
        (put(torso__reference=1.0), "the norm of the quaternion in torso.reference", "x y z w"),
    ],
)
def test_values_out_of_range_are_refused_by_name(
    edit: Edit, field: str, expected: str, controller: Controller
) -> None:
    with pytest.raises(InvalidValue) as caught:
        run(controller, edit)
    assert caught.value.field == field
    assert expected in caught.value.expected
    assert field in str(caught.value)


def test_state_needs_a_unit_quaternion(controller: Controller, robot: Robot) -> None:
    q = robot.home.q.copy()
    q[3:7] = [0.0, 0.0, 0.0, 1.01]
    with pytest.raises(InvalidValue, match=r"norm of the quaternion in q is 1\.01"):
        controller.tick(State(q, robot.home.v), controller.command())


def test_a_quaternion_off_by_rounding_is_normalised(controller: Controller, robot: Robot) -> None:
    state = moving(robot, 5)
    q = state.q.copy()
    q[3:7] *= 1 + 5e-4
    exact, rounded = run(controller, put(), state), run(controller, put(), State(q, state.v))
    np.testing.assert_allclose(rounded.tau, exact.tau, atol=1e-7)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_both_signs_of_a_quaternion_are_one_orientation(
    sign: float, controller: Controller, robot: Robot
) -> None:
    state, command = moving(robot, 6), controller.command()
    expected = controller.tick(state, command).tau
    q = state.q.copy()
    q[3:7] *= sign
    command["pelvis.reference"][3:] *= -sign
    np.testing.assert_allclose(controller.tick(State(q, state.v), command).tau, expected, atol=1e-9)


@pytest.mark.parametrize("size", [0, 1, 23, 25])
def test_a_state_of_another_size_is_refused(
    size: int, controller: Controller, robot: Robot
) -> None:
    with pytest.raises(InvalidValue, match="q"):
        controller.tick(State(np.full(size, 0.5), robot.home.v), controller.command())


@pytest.mark.parametrize(
    "spoil",
    [
        lambda request: request[:-1],
        lambda request: np.append(request, 0.0),
        lambda request: request[None, :],
        lambda request: request.astype(np.float32),
        lambda request: request.astype(">f8"),
        lambda request: np.repeat(request, 2)[::2],
    ],
    ids=["short", "long", "a matrix", "float32", "big endian", "strided"],
)
def test_a_request_that_c_cannot_read_is_refused(
    spoil: Callable[[np.ndarray], np.ndarray], controller: Controller
) -> None:
    with pytest.raises(InvalidValue) as caught:
        controller.run(spoil(controller.command().request))
    assert caught.value.field == "request"


def in_another_process(body: str) -> subprocess.CompletedProcess[str]:
    script = f"""
import numpy as np, tsd_casadi as tsd
robot = tsd.load_robot("hermes_lower")
controller = tsd.compile_controller(robot, on_compile=lambda: None)
command = controller.command()
{body}
"""
    return subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )


@pytest.mark.usefixtures("controller")
def test_a_robot_in_the_air_without_tasks_does_not_crash_the_process() -> None:
    done = in_another_process(
        """
for name in ("com", "pelvis", "torso", "left_foot", "right_foot"):
    command[name + ".active"] = 0.0
command["posture.q_ref"] += 0.1
command["limits.acceleration"] = 1.0
for _ in range(3):
    print(controller.tick(robot.home, command).status.name)
command = controller.command()
print(controller.tick(robot.home, command).status.name)
"""
    )
    assert (done.returncode, done.stdout.split()) == (0, ["OK"] * 4)


ABSURD: dict[str, Edit] = {
    f"{field} of 1e{exponent} along {axis}": (
        lambda command, field=field, axis=axis, exponent=exponent: command[field].__setitem__(
            axis, 10.0**exponent
        )
    )
    for field in ("com.reference", "com.reference_acceleration")
    for axis in range(3)
    for exponent in (5, 6, 7)
}


def test_ok_means_that_the_limits_hold(controller: Controller, robot: Robot) -> None:
    excess = {}
    for name, edit in ABSURD.items():
        command = controller.command()
        command["limits.torque"] *= 0.3
        edit(command)
        tick = controller.tick(robot.home, command)
        if tick.status == Status.OK:
            excess[name] = float((np.abs(tick.tau) - command["limits.torque"]).max())
    assert max(excess.values()) < 1e-4


def test_light_force_weights_leave_the_torque_accurate_or_are_told(controller: Controller) -> None:
    expected = run(controller, put(left_foot__W_lambda=1e-9, right_foot__W_lambda=1e-9))
    assert expected.status == Status.OK
    for weight in (1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-16):
        found = run(controller, put(left_foot__W_lambda=weight, right_foot__W_lambda=weight))
        if found.status != Status.SINGULAR:
            np.testing.assert_allclose(found.tau, expected.tau, atol=5e-4)


def accepted_values(field: Field) -> st.SearchStrategy[float]:
    if field.switch:
        return st.sampled_from([0.0, 1.0])
    edges = [field.lower, 0.0, 1e-9, 1.0, field.upper]
    inside = [value for value in edges if field.lower <= value <= field.upper]
    return st.sampled_from(inside) | st.floats(field.lower, field.upper, allow_subnormal=False)


@st.composite
def accepted_requests(draw: st.DrawFn, controller: Controller) -> Command:
    command = controller.command()
    fields = draw(st.lists(st.sampled_from(list(controller.format.request)), max_size=6))
    for field in fields:
        value = draw(accepted_values(field))
        pattern = draw(st.sampled_from(["all", "one", "signs"]))
        slots = command[field.name]
        if pattern == "one":
            slots[draw(st.integers(0, field.size - 1))] = value
        else:
            slots[:] = value
        if pattern == "signs" and field.lower < 0 and not field.switch:
            slots[::2] *= -1
        if field.unit_quaternion is not None:
            turn = Rotation.random(random_state=draw(st.integers(0, 1000))).as_quat()
            slots[field.unit_quaternion : field.unit_quaternion + 4] = turn
    # all off is the crash above
    command["com.active"] = 1.0
    return command


@settings(max_examples=settings.default.max_examples * 4)
@given(data=st.data())
def test_whatever_is_accepted_is_answered_with_finite_numbers(
    controller: Controller, data: st.DataObject
) -> None:
    command = data.draw(accepted_requests(controller))
    tick = Tick(controller.format, controller.run(command.request))
    assert np.isfinite(tick.reply).all()
    assert tick.status in Status
    if tick.status != Status.OK:
        assert (np.abs(tick.tau) <= command["limits.torque"]).all()
        assert not tick.qdd.any()
        assert not any(wrench.any() for wrench in tick.wrenches.values())


@given(seed=st.integers(0, 10_000))
def test_many_absurd_numbers_at_once_are_survived(controller: Controller, seed: int) -> None:
    rng, layout = np.random.default_rng(seed), controller.format.request
    command = controller.command()
    magnitudes = 10.0 ** rng.uniform(-9, 9, layout.size) * rng.choice([-1, 1], layout.size)
    chosen = rng.random(layout.size) < rng.choice([0.05, 0.3, 1.0])
    for index in (*layout.switches(), *(i + k for i in layout.quaternions() for k in range(4))):
        chosen[index] = False
    request = np.where(chosen, magnitudes, command.request)
    reply = controller.run(np.clip(request, layout.lower(), layout.upper()))
    tick = Tick(controller.format, reply)
    assert np.isfinite(reply).all()
    if tick.status != Status.OK:
        limits = np.clip(request, 0, None)[layout.slice("limits.torque")]
        assert (np.abs(tick.tau) <= limits).all()


def test_times_are_told_and_positive(controller: Controller) -> None:
    tick = run(controller, put())
    assert 0 < tick.compute_time < 1e5
    assert tick.iterations >= 0


def test_a_library_that_is_none_is_told(controller: Controller, tmp_path: Path) -> None:
    library = tmp_path / "controller.so"
    library.write_bytes(b"no shared library")
    with pytest.raises(NotLoadable, match="delete it") as caught:
        Controller(controller.format, library)
    assert caught.value.path == library
