"""A controller behind a Zenoh query, used like a local one."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import zenoh

from tsd_casadi.exceptions import (
    LayoutMismatch,
    MalformedMessage,
    ServiceUnreachable,
    TsdError,
    TwoServices,
)
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.tick import Tick
from tsd_casadi.wire.endpoints import CONTROLLER
from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.keys import info_key, tick_key
from tsd_casadi.wire.tick_message import REPLY, REQUEST, TickMessage, pack_tick, unpack_tick
from tsd_casadi.wire.zenoh_file import ZenohFile
from tsd_clients.remote.session import PATIENCE, Session

TICK_TIMEOUT = 0.5  # s

_log = logging.getLogger(__name__)


class RemoteController:
    """Asks a controller service at every tick.

    A tick without an answer is asked again until the patience is over: the
    service keeps nothing between ticks, so one that was restarted goes on
    where the other stopped.

    Only the instance that ``info`` named is believed. The reply of any other is
    dropped and counted, never applied; since an id can be copied, this guards
    against accidents, the service's access list against strangers.

    Attributes:
        format: The meaning of requests and replies, from the service.
        model: Fingerprint of the service's robot description.
        foreign_replies: Replies that were dropped, since they came from another
            instance than the one that is believed, or held no numbers.
    """

    def __init__(
        self,
        robot: str,
        connect: Sequence[str] = (CONTROLLER,),
        *,
        zenoh_file: ZenohFile | None = None,
    ) -> None:
        """Connect and ask what the service is.

        Args:
            connect: Endpoints of the service.
            zenoh_file: Certificates and what else the network needs.

        Raises:
            ServiceUnreachable: If no service answers.
            TwoServices: If more than one does.
        """
        self._robot = robot
        self._session = Session("controller", connect, zenoh_file=zenoh_file)
        self._sequence = 0
        self.foreign_replies = 0
        try:
            self._session.wait_for(robot)
            info = self.info()
            self.format: TickFormat = info.tick_format()
            self.model = info.model
            self._instance = info.instance
            self._layout = self.format.layout_hash
            self._tau = self.format.reply.slice("tau")
            self._querier: Any = self._session.zenoh.declare_querier(
                tick_key(robot),
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                timeout=TICK_TIMEOUT,
                express=True,
            )
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        """Name robot, endpoints and the instance that is believed."""
        at = ", ".join(self._session.endpoints)
        return f"<RemoteController of {self._robot} at {at}: instance {self._instance}>"

    def __enter__(self) -> RemoteController:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the session."""
        self.close()

    def close(self) -> None:
        """Close the session."""
        self._session.close()

    def info(self) -> InfoMessage:
        """Ask what the service is and how many ticks it has served.

        Raises:
            TwoServices: If more than one answers.
        """
        bodies = self._session.query(info_key(self._robot))
        infos = {info.instance: info for info in map(InfoMessage.decode, bodies)}
        if len(infos) > 1:
            raise TwoServices(
                f"{len(infos)} controllers answer for {self._robot} (instances "
                f"{', '.join(map(str, infos))}); stop all but one, or connect to one endpoint"
            )
        return next(iter(infos.values()))

    def command(self) -> Command:
        """Make a new command, which holds the home posture."""
        return Command(self.format.request)

    def tick(self, state: State, command: Command) -> Tick:
        """Torque for one state and command.

        Args:
            command: What to do; its request vector takes the state.

        Returns:
            The tick; look at its status before using more than tau. Its torque
            keeps the command's ``limits.torque``, whoever answered.

        Raises:
            InvalidValue: If the service refused the numbers.
            ServiceUnreachable: If it did not answer for some seconds.
            TwoServices: If another service says that it is the controller.
            LayoutMismatch: If the service was restarted with another formulation.
        """
        command.set_state(state)
        self._sequence += 1
        payload = pack_tick(REQUEST, self._layout, self._sequence, command.request)
        reply = self._ask_once(payload)
        end = time.monotonic() + PATIENCE
        while reply is None:
            if time.monotonic() > end:
                raise ServiceUnreachable(
                    "controller", self._session.endpoints, f"no reply for {PATIENCE:g} s"
                )
            time.sleep(0.02)
            reply = self._ask_once(payload)
        limit = command["limits.torque"]
        tau = reply[self._tau]
        np.clip(tau, -limit, limit, out=tau)
        return Tick(self.format, reply)

    def _ask_once(self, payload: bytes) -> Vector | None:
        """Find the reply of the instance that is believed; None if it has to be asked again."""
        strangers: list[int] = []
        refusal: TsdError | None = None
        try:
            for reply in self._querier.get(payload=payload):
                try:
                    message = self._read(reply)
                except ServiceUnreachable:
                    refusal = None  # timed out: who refused need not be the controller
                    continue
                except TsdError as error:
                    refusal = error  # names no instance, so a torque goes before it
                    continue
                if message is None or message.instance != self._instance:
                    strangers.append(0 if message is None else message.instance)
                elif message.sequence == self._sequence:
                    self._drop(strangers)
                    return message.values.copy()
        except zenoh.ZError:
            refusal = None  # closed without a reply
        if refusal is not None:
            raise refusal
        if strangers and self._has_restarted():
            strangers = [stranger for stranger in strangers if stranger != self._instance]
        self._drop(strangers)
        return None

    def _read(self, reply: Any) -> TickMessage | None:
        """Read a reply's message; None if it is nothing that a controller of ours sends."""
        body = self._session.body_of(reply)
        try:
            message = unpack_tick(body, REPLY, self._layout, self.format.reply.size)
        except MalformedMessage:
            return None
        return message if np.isfinite(message.values).all() else None

    def _drop(self, strangers: list[int]) -> None:
        """Count replies that were not believed, and say so once."""
        if strangers and self.foreign_replies == 0:
            _log.warning(
                "a tick of %s was answered by a stranger (instance %d, where %d is believed); such "
                "replies are dropped and counted. Look for another program on the key %s",
                self._robot,
                strangers[0],
                self._instance,
                tick_key(self._robot),
            )
        self.foreign_replies += len(strangers)

    def _has_restarted(self) -> bool:
        """Whether the controller is another instance now; that one is believed from here on."""
        info = self.info()  # refuses two services at once
        if info.tick_format().layout_hash != self._layout:
            raise LayoutMismatch(
                "the restarted controller has another formulation", "the one the run began with"
            )
        if info.instance == self._instance:
            return False
        self._instance = info.instance
        return True
