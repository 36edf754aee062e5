"""The controller service: ticks in, torques out, with no memory in between."""

from __future__ import annotations

import sys

import zenoh

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.controller.controller import Controller
from tsd_casadi.exceptions import InvalidValue, MalformedMessage
from tsd_casadi.robot.robot import Robot
from tsd_casadi.tick.format import Status
from tsd_casadi.version import __version__
from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.keys import health_key, info_key, tick_key
from tsd_casadi.wire.tick_message import REPLY, REQUEST, VERSION, pack_tick, unpack_tick
from tsd_server.place import Place
from tsd_server.say import say
from tsd_server.service import Service, reply_json

BINARY = zenoh.Encoding.APPLICATION_OCTET_STREAM


class ControllerService:
    """Answers tick and info queries for one robot.

    Attributes:
        controller: The compiled controller.
        ticks_served: Ticks answered with a torque.
        ticks_refused: Ticks answered with an error.
    """

    def __init__(self, robot: Robot, place: Place) -> None:
        """Open the session, then compile or load the controller.

        The session comes first: a taken port is told before minutes of
        compiling, and queries wait until the service is ready.

        Args:
            place: Where to listen.

        Raises:
            AlreadyRunning: If the robot has a controller.
            EndpointTaken: If it cannot listen there.
            CompilerNotFound: If there is nothing to compile with.
        """
        self._robot = robot
        self._service = Service("controller", robot.name, place)
        try:
            self.controller: Controller = compile_controller(robot, self._tell_compiling)
        except BaseException:
            self._service.__exit__(None, None, None)
            raise
        self.ticks_served = 0
        self.ticks_refused = 0
        self._format = self.controller.format
        self._layout = self._format.layout_hash
        self._key = tick_key(robot.name)
        self._status = self._format.reply.slice("status").start
        self._statuses = [0] * len(Status)
        self._description = self._describe()

    def _tell_compiling(self) -> None:
        say(
            f"compiling the controller of {self._robot.name}: once on this machine, about 20 s",
            sys.stderr,
        )

    def run(self) -> None:
        """Serve until SIGINT or SIGTERM."""
        name = self._robot.name
        with self._service as service:
            service.answer(self._key, self._tick)
            service.answer(info_key(name), self._info)
            service.answer(health_key(name, "controller"), self._health)
            size = self._format.request.size
            service.run(
                f"robot {name}, {self._robot.n} joints, "
                f"{len(self._format.row_names)} rows, request of {size} float64"
            )

    def _tick(self, query: zenoh.Query) -> None:
        try:
            payload = query.payload
            if payload is None:
                raise MalformedMessage("no payload", "a packed tick request; see docs/wire.md")
            message = unpack_tick(
                payload.to_bytes(), REQUEST, self._layout, self._format.request.size
            )
            reply = self.controller.run(message.values)
        except (MalformedMessage, InvalidValue):
            self.ticks_refused += 1
            raise
        self.ticks_served += 1
        self._statuses[int(reply[self._status])] += 1
        query.reply(
            self._key,
            pack_tick(REPLY, self._layout, message.sequence, reply, self._service.instance),
            encoding=BINARY,
            express=True,
        )

    def _describe(self) -> bytes:
        """Describe the controller once, but for the counters at the end.

        To write 17 kB for each query would keep the ticks waiting.
        """
        info = InfoMessage.of(
            self._format,
            version=__version__,
            instance=self._service.instance,
            protocol=VERSION,
            model=self._robot.fingerprint,
            body=self._robot.body_fingerprint,
            formulation=self._robot.formulation_fingerprint,
            ticks_served=0,
            ticks_refused=0,
        )
        return info.encode().removesuffix(b'"ticks_served":0,"ticks_refused":0}')

    def _info(self, query: zenoh.Query) -> None:
        counters = f'"ticks_served":{self.ticks_served},"ticks_refused":{self.ticks_refused}}}'
        body = self._description + counters.encode()
        reply_json(query, info_key(self._robot.name), body)

    def _health(self, query: zenoh.Query) -> None:
        ticks = {
            status.name.lower(): count
            for status, count in zip(Status, self._statuses, strict=True)
            if count
        }
        body = self._service.health(ticks=ticks).encode()
        reply_json(query, health_key(self._robot.name, "controller"), body)
