"""Which controller's replies are believed."""

from __future__ import annotations

import logging
import threading
from typing import Any

import numpy as np

from tsd_casadi.exceptions import (
    InvalidValue,
    LayoutMismatch,
    MalformedMessage,
    ServiceUnreachable,
    TsdError,
    TwoServices,
)
from tsd_casadi.state import Vector
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.missed import Cause, Missed
from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.keys import info_key, tick_key
from tsd_casadi.wire.tick_message import REPLY, TickMessage, unpack_tick
from tsd_clients.remote.session import Session

_log = logging.getLogger(__name__)


def ask_info(session: Session, robot: str) -> InfoMessage:
    """Ask what the controller is.

    Raises:
        ServiceUnreachable: If none answers.
        TwoServices: If more than one does.
    """
    bodies = session.query(info_key(robot))
    infos = {info.instance: info for info in map(InfoMessage.decode, bodies)}
    if len(infos) > 1:
        raise TwoServices(
            f"{len(infos)} controllers answer for {robot} (instances "
            f"{', '.join(map(str, infos))}); stop all but one, or connect to one endpoint"
        )
    return next(iter(infos.values()))


class Belief:
    """Only the instance that ``info`` named is believed.

    The reply of any other is dropped and counted, never applied; since an id can be
    copied, this guards against accidents, the service's access list against strangers.

    Attributes:
        format: The meaning of requests and replies.
        layout: Its hash.
        instance: Who is believed.
        foreign_replies: Replies that were dropped.
    """

    def __init__(self, session: Session, robot: str, info: InfoMessage) -> None:
        """Believe the controller that says what it is."""
        self._session, self._robot = session, robot
        self.format: TickFormat = info.tick_format()
        self.layout = self.format.layout_hash
        self.instance = info.instance
        self.foreign_replies = 0
        self._looking: threading.Thread | None = None
        self._failure: TsdError | None = None

    def read(self, reply: Any) -> TickMessage | None:
        """Read a reply's message; None if it is nothing that a controller of ours sends.

        Raises:
            TsdError: What the controller refused.
            ServiceUnreachable: If it is Zenoh's time-out.
        """
        body = self._session.body_of(reply)
        try:
            message = unpack_tick(body, REPLY, self.layout, self.format.reply.size)
        except MalformedMessage:
            return None
        return message if np.isfinite(message.values).all() else None

    def drop(self, strangers: list[int]) -> None:
        """Count replies that were not believed, and say so once.

        Args:
            strangers: Their instances, 0 where they told none.
        """
        if strangers and self.foreign_replies == 0:
            _log.warning(
                "a tick of %s was answered by a stranger (instance %d, where %d is believed); such "
                "replies are dropped and counted. Look for another program on the key %s",
                self._robot,
                strangers[0],
                self.instance,
                tick_key(self._robot),
            )
        self.foreign_replies += len(strangers)

    def has_restarted(self) -> bool:
        """Ask whether the controller is another instance now; that one is believed from here on.

        Raises:
            TwoServices: If another service says that it is the controller too.
            LayoutMismatch: If the controller has another formulation now.
        """
        try:
            info = ask_info(self._session, self._robot)
        except ServiceUnreachable:
            return False  # gone again
        if info.tick_format().layout_hash != self.layout:
            raise LayoutMismatch(
                "the restarted controller has another formulation", "the one the run began with"
            )
        if info.instance == self.instance:
            return False
        self.instance = info.instance
        return True

    def judge(self, reply: Any, sequence: int) -> Vector | Missed:
        """Take a reply's numbers, or tell why they cannot be used; waits for nobody.

        Args:
            sequence: Of the question.

        Raises:
            TsdError: If an earlier look found another controller; see ``has_restarted``.
        """
        try:
            message = self.read(reply)
        except ServiceUnreachable:
            return Missed(Cause.LATE, "no reply")
        except (InvalidValue, MalformedMessage) as error:
            return Missed(Cause.REFUSED, str(error))
        except TsdError as error:
            return Missed(Cause.ERROR, str(error))
        if message is None or message.instance != self.instance:
            self._look_again(0 if message is None else message.instance)
            return Missed(Cause.ERROR, "the reply is not of the controller that is believed")
        if message.sequence != sequence:
            return Missed(Cause.ERROR, "the reply is of another question")
        return message.values.copy()

    def _look_again(self, stranger: int) -> None:
        """Find out whether the controller has restarted, while the caller goes on.

        Args:
            stranger: Instance of the reply that asks for it; counted if it is not the
                restarted controller's.

        Raises:
            TsdError: What the last time found, see ``has_restarted``.
        """
        if self._failure is not None:
            raise self._failure
        if self._looking is None or not self._looking.is_alive():
            self._looking = threading.Thread(target=self._look, args=(stranger,), daemon=True)
            self._looking.start()

    def _look(self, stranger: int) -> None:
        try:
            self.has_restarted()
        except TsdError as error:
            self._failure = error
        if stranger != self.instance:
            self.drop([stranger])
