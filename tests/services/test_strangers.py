"""A stranger's torque is never believed, however the stranger came to the service."""

import json
import logging
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
import zenoh

import tsd_casadi as tsd
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import EntryNotFound, ServiceUnreachable, TwoServices
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.wire.error import ErrorMessage
from tsd_casadi.wire.feedforward import FeedforwardMessage
from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.keys import feedforward_key, info_key, tick_key
from tsd_casadi.wire.session_settings import session_settings
from tsd_casadi.wire.tick_message import REPLY, REQUEST, VERSION, pack_tick, unpack_tick
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_server.service_process import ServiceProcess, free_endpoint

STRANGE_TORQUE = 7777.0


def open_session(
    *, mode: str = "peer", guarded: bool = True, listen: tuple[str, ...] = (), connect: str = ""
) -> zenoh.Session:
    settings = session_settings(
        listen=listen,
        connect=[connect] if connect else [],
        service="controller" if listen and guarded else None,
    )
    settings["mode"] = mode
    return zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))


def answer_ticks(
    session: zenoh.Session,
    layout: TickFormat,
    *,
    key: str | None = None,
    instance: int = 666,
    torque: float = STRANGE_TORQUE,
    delay: float = 0.0,
) -> object:
    """Answer every tick with a torque of its own making."""
    reply = np.zeros(layout.reply.size)
    reply[layout.reply.slice("tau")] = torque

    def answer(query: zenoh.Query) -> None:
        with query:
            payload = query.payload
            assert payload is not None
            message = unpack_tick(
                payload.to_bytes(), REQUEST, layout.layout_hash, layout.request.size
            )
            time.sleep(delay)
            body = pack_tick(REPLY, layout.layout_hash, message.sequence, reply, instance)
            query.reply(tick_key(layout.robot), body)

    handler = zenoh.handlers.Callback(answer, indirect=delay > 0)
    return session.declare_queryable(key or tick_key(layout.robot), handler, complete=True)


class Genuine:
    """The least that a client takes for a controller; relays all, since nothing guards it."""

    def __init__(self, layout: TickFormat, *, instance: int = 5, delay: float = 0.0) -> None:
        self.endpoint = free_endpoint()
        self.instance = instance
        self.layout = layout
        # a peer relays clients only, a router everybody
        self.session = open_session(mode="router", guarded=False, listen=(self.endpoint,))
        name = layout.robot
        self.token = self.session.liveliness().declare_token(f"tsd/{name}/controller/alive")
        handler = zenoh.handlers.Callback(self._info, indirect=False)
        self._parts = [
            self.session.declare_queryable(info_key(name), handler, complete=True),
            answer_ticks(self.session, layout, instance=instance, torque=1.0, delay=delay),
        ]

    def _info(self, query: zenoh.Query) -> None:
        info = InfoMessage.of(
            self.layout,
            version="0",
            instance=self.instance,
            protocol=VERSION,
            model="",
            body="00ff",
            formulation="ff00",
            ticks_served=0,
            ticks_refused=0,
        )
        with query:
            query.reply(info_key(self.layout.robot), info.encode())

    def stop_answering_ticks(self) -> None:
        self._parts.pop().undeclare()  # type: ignore[attr-defined]


@contextmanager
def served(layout: TickFormat, delay: float = 0.0) -> Iterator[Genuine]:
    genuine = Genuine(layout, delay=delay)
    try:
        yield genuine
    finally:
        genuine.session.close()  # type: ignore[no-untyped-call]


@pytest.fixture(scope="module")
def service(controller: tsd.Controller) -> Iterator[str]:
    endpoint = free_endpoint()
    with ServiceProcess(["controller", "--listen", endpoint]):
        yield endpoint


def test_no_tick_of_a_thousand_is_believed(
    robot: tsd.Robot, controller: tsd.Controller, service: str
) -> None:
    ticks = 0
    keys = (tick_key(robot.name), "tsd/herm$*/controller/*", "tsd/**", "**")
    for mode in ("client", "peer", "router"):
        for key in keys:
            for first in (True, False):  # the stranger before the client, and after it
                stranger = open_session(mode=mode, connect=service)
                parts = [answer_ticks(stranger, controller.format, key=key)] if first else []
                with RemoteController(robot.name, [service]) as remote:
                    if not first:
                        parts.append(answer_ticks(stranger, controller.format, key=key))
                    for _ in range(42):
                        tick = remote.tick(robot.home, remote.command())
                        assert np.max(np.abs(tick.tau)) < 200.0
                        ticks += 1
                    # the service relayed none of them
                    assert remote.foreign_replies == 0
                stranger.close()  # type: ignore[no-untyped-call]
                del parts
    assert ticks >= 1000


@contextmanager
def stranger_of(
    genuine: Genuine, answer: Callable[[zenoh.Session], object], mode: str = "client"
) -> Iterator[None]:
    session = open_session(mode=mode, connect=genuine.endpoint)
    part = answer(session)
    try:
        yield
    finally:
        del part
        session.close()  # type: ignore[no-untyped-call]


def tick_until(remote: RemoteController, robot: tsd.Robot, done: Callable[[], bool]) -> None:
    """Tick until links and declarations have arrived, however long they take."""
    deadline = time.monotonic() + 10.0
    while not done():
        assert time.monotonic() < deadline
        assert np.all(remote.tick(robot.home, remote.command()).tau == 1.0)


@pytest.mark.parametrize("mode", ["client", "router"])
@pytest.mark.parametrize("first", [True, False])
def test_client_alone_drops_strangers_where_nothing_guards_the_service(
    controller: tsd.Controller, robot: tsd.Robot, mode: str, first: bool
) -> None:
    def answer(session: zenoh.Session) -> object:
        return answer_ticks(session, controller.format)

    # a genuine answer that comes first is taken at once: here it is the last one
    with served(controller.format, delay=0.02) as genuine, ExitStack() as stack:
        if first:
            stack.enter_context(stranger_of(genuine, answer, mode))
        remote = stack.enter_context(RemoteController(robot.name, [genuine.endpoint]))
        if not first:
            stack.enter_context(stranger_of(genuine, answer, mode))
        tick_until(remote, robot, lambda: remote.foreign_replies >= 20)


def test_client_drops_a_peer_that_it_is_connected_to(
    controller: tsd.Controller, robot: tsd.Robot
) -> None:
    # no service relays peers; one may be at an endpoint that the user named
    elsewhere = free_endpoint()
    stranger = open_session(guarded=False, listen=(elsewhere,))
    part = answer_ticks(stranger, controller.format)
    with (
        served(controller.format, delay=0.02) as genuine,
        RemoteController(robot.name, [genuine.endpoint, elsewhere]) as remote,
    ):
        tick_until(remote, robot, lambda: remote.foreign_replies >= 20)
    del part
    stranger.close()  # type: ignore[no-untyped-call]


def test_only_strangers_answer(
    controller: tsd.Controller,
    robot: tsd.Robot,
    caplog: pytest.LogCaptureFixture,
) -> None:
    with (
        served(controller.format, delay=0.02) as genuine,
        RemoteController(robot.name, [genuine.endpoint], 0.3) as remote,
        stranger_of(genuine, lambda session: answer_ticks(session, controller.format)),
        caplog.at_level(logging.WARNING),
    ):
        tick_until(remote, robot, lambda: remote.foreign_replies > 0)
        genuine.stop_answering_ticks()
        with pytest.raises(ServiceUnreachable, match="no controller answered"):
            remote.tick(robot.home, remote.command())
        assert len(caplog.records) == 1
        assert "answered by a stranger (instance 666, where 5 is believed)" in caplog.text


def test_a_copied_id_keeps_the_torque_limit(controller: tsd.Controller, robot: tsd.Robot) -> None:
    with served(controller.format) as genuine:
        genuine.stop_answering_ticks()
        part = answer_ticks(genuine.session, controller.format, instance=genuine.instance)
        with RemoteController(robot.name, [genuine.endpoint]) as remote:
            command = remote.command()
            command["limits.torque"] *= 0.5
            tau = remote.tick(robot.home, command).tau
            np.testing.assert_array_equal(tau, 0.5 * robot.torque_limit)
        del part


def test_a_copied_id_with_numbers_that_are_none_is_dropped(
    controller: tsd.Controller, robot: tsd.Robot
) -> None:
    with served(controller.format) as genuine:
        genuine.stop_answering_ticks()
        part = answer_ticks(
            genuine.session, controller.format, instance=genuine.instance, torque=np.nan
        )
        with RemoteController(robot.name, [genuine.endpoint], 0.3) as remote:
            with pytest.raises(ServiceUnreachable, match="no controller answered"):
                remote.tick(robot.home, remote.command())
            assert remote.foreign_replies > 0
        del part


def test_a_strangers_refusal_does_not_hide_the_torque(
    controller: tsd.Controller, robot: tsd.Robot
) -> None:
    refused = threading.Event()

    def refuse(query: zenoh.Query) -> None:
        with query:
            query.reply_err(ErrorMessage(code="invalid_value", message="no").encode())
        refused.set()

    def declare(session: zenoh.Session) -> object:
        handler = zenoh.handlers.Callback(refuse, indirect=False)
        return session.declare_queryable(tick_key(robot.name), handler, complete=True)

    with (
        served(controller.format) as genuine,
        RemoteController(robot.name, [genuine.endpoint]) as remote,
        stranger_of(genuine, declare),
    ):
        tick_until(remote, robot, refused.is_set)
        for _ in range(100):
            assert np.all(remote.tick(robot.home, remote.command()).tau == 1.0)


@pytest.mark.parametrize("body", [b"", b"no", b"\xff", b'{"code": "unreachable", "message": ""}'])
def test_an_error_that_says_nothing_does_not_hide_the_torque(
    controller: tsd.Controller, robot: tsd.Robot, body: bytes
) -> None:
    refused = threading.Event()

    def refuse(query: zenoh.Query) -> None:
        with query:
            query.reply_err(body)
        refused.set()

    def declare(session: zenoh.Session) -> object:
        handler = zenoh.handlers.Callback(refuse, indirect=False)
        return session.declare_queryable(tick_key(robot.name), handler, complete=True)

    # the stranger's error comes first
    with (
        served(controller.format, delay=0.02) as genuine,
        RemoteController(robot.name, [genuine.endpoint]) as remote,
        stranger_of(genuine, declare),
    ):
        tick_until(remote, robot, refused.is_set)
        for _ in range(20):
            assert np.all(remote.tick(robot.home, remote.command()).tau == 1.0)


def test_a_stranger_that_never_answers_does_not_hide_what_the_controller_says(
    controller: tsd.Controller, robot: tsd.Robot
) -> None:
    asked = threading.Event()
    kept = []

    def keep(query: zenoh.Query) -> None:
        kept.append(query)  # as long as it is kept, its querier waits
        asked.set()

    def declare(session: zenoh.Session) -> object:
        handler = zenoh.handlers.Callback(keep, indirect=False)
        return session.declare_queryable(info_key(robot.name), handler, complete=True)

    with (
        served(controller.format) as genuine,
        RemoteController(robot.name, [genuine.endpoint]) as remote,
        stranger_of(genuine, declare),
    ):
        while not asked.is_set():  # bounded by the test's time
            bodies = remote._session.query(info_key(robot.name), timeout=0.5)
            assert [InfoMessage.decode(body).instance for body in bodies] == [genuine.instance]
        kept.clear()


def test_a_client_connects_to_nobody_but_its_service(
    controller: tsd.Controller, robot: tsd.Robot, service: str
) -> None:
    settings = session_settings(listen=[free_endpoint()], connect=[service])
    settings["scouting"]["gossip"]["enabled"] = True  # tells everybody where it is
    config = zenoh.Config.from_json5(json.dumps(settings))
    with zenoh.open(config), RemoteController(robot.name, [service]) as remote:
        for _ in range(100):
            remote.tick(robot.home, remote.command())
        assert len(list(remote._session.zenoh.info.peers_zid())) == 1


@pytest.mark.parametrize("mode", ["client", "peer", "router"])
def test_no_feedforward_of_a_stranger_is_believed(mode: str, tmp_path: Path) -> None:
    endpoint = free_endpoint()
    basis = PeriodicBasis()
    weights = np.full((1, basis.L), STRANGE_TORQUE)
    strange = Feedforward(
        axes=("com.z",),
        basis=basis,
        weights=weights,
        standard_deviations=weights,
        kind="learned",
        parameters={"amplitude": 0.05, "frequency": 0.25, "height": 0.0},
        provenance={"entries": [1], "iteration": 1},
    )

    def answer(query: zenoh.Query) -> None:
        with query:
            message = FeedforwardMessage.of("hermes_lower", "squat", strange)
            query.reply(feedforward_key("hermes_lower"), message.encode())

    arguments = ["learner", "--database", str(tmp_path / "a.sqlite"), "--listen", endpoint]
    with ServiceProcess(arguments):
        stranger = open_session(mode=mode, connect=endpoint)
        handler = zenoh.handlers.Callback(answer, indirect=False)
        part = stranger.declare_queryable("tsd/**", handler, complete=True)
        with RemoteLearner([endpoint]) as learner:
            for _ in range(50):
                with pytest.raises(EntryNotFound):
                    learner.query("squat", robot="hermes_lower", amplitude=0.05, frequency=0.25)
        del part
        stranger.close()  # type: ignore[no-untyped-call]


def test_who_claims_to_be_the_controller_as_well_is_refused(
    controller: tsd.Controller, robot: tsd.Robot
) -> None:
    with served(controller.format) as genuine:
        other = Genuine(controller.format, instance=6)
        try:
            with pytest.raises(TwoServices, match="2 controllers"):
                while True:  # the second link may come up later; bounded by the test's time
                    RemoteController(robot.name, [genuine.endpoint, other.endpoint]).close()
        finally:
            other.session.close()  # type: ignore[no-untyped-call]
