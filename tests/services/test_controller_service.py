import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import zenoh

import tsd_casadi as tsd
from tsd_casadi.exceptions import InvalidValue, ServiceNotReady, ServiceUnreachable, TwoServices
from tsd_casadi.wire.error import ErrorMessage
from tsd_casadi.wire.keys import info_key, tick_key
from tsd_casadi.wire.tick_message import HEADER, REPLY, REQUEST, pack_tick, unpack_tick
from tsd_clients.remote.remote_controller import RemoteController
from tsd_server.service_process import ServiceProcess, free_endpoint

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def endpoint(controller: tsd.Controller) -> Iterator[str]:
    # the session's controller is compiled already, so this starts from the cache
    endpoint = free_endpoint()
    with ServiceProcess(["controller", "--listen", endpoint]):
        yield endpoint


@pytest.fixture
def remote(robot: tsd.Robot, endpoint: str) -> Iterator[RemoteController]:
    with RemoteController(robot.name, [endpoint]) as remote:
        yield remote


def send(session: zenoh.Session, robot: str, payload: bytes | None) -> zenoh.Reply:
    return next(iter(session.get(tick_key(robot), payload=payload, timeout=5.0)))


def test_remote_tick_is_the_local_tick_to_the_bit(
    robot: tsd.Robot, controller: tsd.Controller, remote: RemoteController
) -> None:
    rng = np.random.default_rng(0)
    tau = controller.format.reply.slice("tau")
    active = controller.format.reply.slice("active")
    for stress in (1.0, 0.2):
        command = remote.command()
        command["limits.torque"] *= stress
        state = tsd.State(robot.home.q, 0.1 * rng.normal(size=robot.nv))
        there = remote.tick(state, command).reply
        here = controller.tick(state, command).reply
        for field in (tau, active):
            np.testing.assert_array_equal(there[field], here[field])


def test_format_and_defaults_arrive_unchanged(
    controller: tsd.Controller, remote: RemoteController
) -> None:
    assert remote.format == controller.format
    np.testing.assert_array_equal(remote.command().request, controller.command().request)


def test_info_counts_ticks(robot: tsd.Robot, remote: RemoteController) -> None:
    before = remote.info()
    for _ in range(7):
        remote.tick(robot.home, remote.command())
    command = remote.command()
    command["com.P"] = np.nan
    with pytest.raises(InvalidValue, match=r"com\.P\[0\] is nan"):
        remote.tick(robot.home, command)
    after = remote.info()
    assert after.ticks_served - before.ticks_served == 7
    assert after.ticks_refused - before.ticks_refused == 1


@pytest.mark.parametrize(
    ("spoil", "code"),
    [
        (lambda message: None, "malformed"),
        (lambda message: b"", "malformed"),
        (lambda message: message[:20], "malformed"),
        (lambda message: message[:-8], "malformed"),
        (lambda message: message + b"\0", "malformed"),
        (lambda message: b"NOPE" + message[4:], "malformed"),
        (lambda message: message[:4] + b"\x63\0" + message[6:], "version"),
        (lambda message: message[:8] + bytes(8) + message[16:], "layout"),
        (
            lambda message: message[: HEADER.size] + b"\xff" * 8 + message[HEADER.size + 8 :],
            "invalid_value",
        ),
    ],
)
def test_bad_tick_is_refused_with_a_code_and_the_next_one_served(
    robot: tsd.Robot,
    controller: tsd.Controller,
    raw_session: zenoh.Session,
    spoil: object,
    code: str,
) -> None:
    assert callable(spoil)
    layout = controller.format.layout_hash
    good = pack_tick(REQUEST, layout, 3, controller.command().request)
    reply = send(raw_session, robot.name, spoil(good))
    assert reply.err is not None
    error = ErrorMessage.decode(reply.err.payload.to_bytes())
    assert error.code == code
    assert "expected" in error.message
    reply = send(raw_session, robot.name, good)
    assert reply.ok is not None
    message = unpack_tick(reply.ok.payload.to_bytes(), REPLY, layout, controller.format.reply.size)
    assert message.sequence == 3
    assert message.values[0] == 0.0


def test_two_simulators_share_one_controller(robot: tsd.Robot, endpoint: str) -> None:
    torques: dict[int, list[np.ndarray]] = {0: [], 1: []}

    def work(which: int) -> None:
        with RemoteController(robot.name, [endpoint]) as remote:
            command = remote.command()
            command["com.reference"][2] += 0.01 * which
            for _ in range(200):
                torques[which].append(remote.tick(robot.home, command).tau)

    threads = [threading.Thread(target=work, args=(which,)) for which in torques]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for taus in torques.values():
        assert len(taus) == 200
        assert np.ptp(np.array(taus), axis=0).max() == 0.0
    assert not np.array_equal(torques[0][0], torques[1][0])


def test_restarted_controller_goes_on(robot: tsd.Robot) -> None:
    endpoint = free_endpoint()
    arguments = ["controller", "--listen", endpoint]
    with ServiceProcess(arguments) as first, RemoteController(robot.name, [endpoint]) as remote:
        before = remote.tick(robot.home, remote.command()).tau
        first.process.kill()
        first.process.wait()
        with ServiceProcess(arguments):
            after = remote.tick(robot.home, remote.command()).tau
    np.testing.assert_array_equal(before, after)


def test_silent_controller_is_reported_within_seconds(robot: tsd.Robot) -> None:
    endpoint = free_endpoint()
    with (
        ServiceProcess(["controller", "--listen", endpoint]) as service,
        RemoteController(robot.name, [endpoint], 1.0) as remote,
    ):
        remote.tick(robot.home, remote.command())
        service.process.send_signal(signal.SIGSTOP)
        # all of its threads; the signal alone is only under way
        os.waitid(os.P_PID, service.process.pid, os.WSTOPPED)
        start = time.monotonic()
        try:
            with pytest.raises(ServiceUnreachable, match=r"waited 1 s for a reply, .*late"):
                remote.tick(robot.home, remote.command())
        finally:
            service.process.send_signal(signal.SIGCONT)
        assert time.monotonic() - start < 15.0


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signal_ends_the_service_cleanly(number: signal.Signals) -> None:
    with ServiceProcess(["controller", "--listen", free_endpoint()]) as service:
        start = time.monotonic()
        service.process.send_signal(number)
        assert service.process.wait(timeout=5.0) == 0
        assert time.monotonic() - start < 2.0
        assert not any("Traceback" in line for line in service.output)


def test_taken_port_is_refused(endpoint: str) -> None:
    with pytest.raises(ServiceNotReady, match=r"cannot listen on .* already in use.*--listen"):
        ServiceProcess(["controller", "--listen", endpoint])


def test_client_refuses_two_controllers(robot: tsd.Robot, endpoint: str) -> None:
    other = free_endpoint()
    with (
        ServiceProcess(["controller", "--listen", other]),
        pytest.raises(TwoServices, match="2 controllers"),
    ):
        deadline = time.monotonic() + 10.0
        while time.monotonic() < deadline:  # the second link may come up later
            RemoteController(robot.name, [endpoint, other]).close()


def test_nobody_there() -> None:
    with pytest.raises(ServiceUnreachable, match="start one with 'tsd controller'"):
        RemoteController("hermes_lower", [free_endpoint()])


def test_other_robot_is_named(endpoint: str) -> None:
    with pytest.raises(ServiceUnreachable, match="it serves robot hermes_lower, not atlas"):
        RemoteController("atlas", [endpoint])


def test_own_simulator_example(endpoint: str) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / "own_simulator.py"), "hermes_lower", endpoint],
        capture_output=True,
        text=True,
        timeout=60,
        env={**os.environ, "PYTHONPATH": ""},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "status 0 (solved)" in done.stdout
    assert len(done.stdout.splitlines()) == 18


def test_own_simulator_example_imports_nothing_of_ours() -> None:
    text = (EXAMPLES / "own_simulator.py").read_text()
    assert "tsd_" not in text.replace("tsd_controller", "")


def test_burst_of_queries_does_not_cut_others_off(
    robot: tsd.Robot, remote: RemoteController, raw_session: zenoh.Session
) -> None:
    pending = [raw_session.get(info_key(robot.name), timeout=5.0) for _ in range(1000)]
    slowest, end = 0.0, time.monotonic() + 3.0
    while time.monotonic() < end:
        start = time.monotonic()
        remote.tick(robot.home, remote.command())
        slowest = max(slowest, time.monotonic() - start)
    answered = sum(reply.ok is not None for replies in pending for reply in replies)
    assert answered > 0
    assert slowest < 2.0
