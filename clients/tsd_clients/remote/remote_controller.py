"""A controller behind a Zenoh query, used like a local one."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import zenoh

from tsd_casadi.repetition.patience import PATIENCE, check_patience
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.missed import Cause, Missed
from tsd_casadi.tick.tick import Tick
from tsd_casadi.wire.endpoints import CONTROLLER
from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.keys import tick_key
from tsd_casadi.wire.tick_message import REQUEST, pack_tick
from tsd_casadi.wire.zenoh_file import ZenohFile
from tsd_clients.remote.belief import Belief, ask_info
from tsd_clients.remote.lock_step import TICK_TIMEOUT, LockStep
from tsd_clients.remote.session import Session
from tsd_clients.remote.tick_exchange import TickExchange


class RemoteController:
    """Asks a controller service at every tick.

    A tick without an answer is asked again until the patience is over: the
    service keeps nothing between ticks, so one that was restarted goes on
    where the other stopped.

    Attributes:
        format: The meaning of requests and replies, from the service.
        model: Fingerprint of the service's robot description.
    """

    def __init__(
        self,
        robot: str,
        connect: Sequence[str] = (CONTROLLER,),
        patience: float = PATIENCE,
        *,
        zenoh_file: ZenohFile | None = None,
    ) -> None:
        """Connect and ask what the service is.

        Args:
            connect: Endpoints of the service.
            patience: How long ``tick`` asks again [s]; infinite for ever.
            zenoh_file: Certificates and what else the network needs.

        Raises:
            ServiceUnreachable: If no service answers.
            TwoServices: If more than one does.
            InvalidValue: If the patience is none.
        """
        check_patience(patience)
        self._robot = robot
        self._session = Session("controller", connect, zenoh_file=zenoh_file)
        self._sequence = 0
        try:
            self._session.wait_for(robot)
            info = self.info()
            self._belief = Belief(self._session, robot, info)
            self.format: TickFormat = self._belief.format
            self.model = info.model
            self._tau = self.format.reply.slice("tau")
            self._querier: Any = self._session.zenoh.declare_querier(
                tick_key(robot),
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                timeout=TICK_TIMEOUT,
                express=True,
            )
            self._lock_step = LockStep(
                self._querier, self._belief, self._session.endpoints, patience
            )
            self._exchange = TickExchange(self._querier)
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        """Name robot, endpoints and the instance that is believed."""
        at = ", ".join(self._session.endpoints)
        return f"<RemoteController of {self._robot} at {at}: instance {self._belief.instance}>"

    def __enter__(self) -> RemoteController:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the session."""
        self.close()

    def close(self) -> None:
        """Close the session."""
        self._session.close()

    @property
    def foreign_replies(self) -> int:
        """Replies that were dropped: of an instance that is not believed, or without numbers."""
        return self._belief.foreign_replies

    @property
    def waited(self) -> dict[Cause, float]:
        """How long ``tick`` waited for answers that did not come at once [s], by cause."""
        return self._lock_step.waited

    @property
    def late_replies(self) -> int:
        """Replies that were dropped by ``tick_within``, since they came too late."""
        return self._exchange.late

    def info(self) -> InfoMessage:
        """Ask what the service is and how many ticks it has served.

        Raises:
            TwoServices: If more than one answers.
        """
        return ask_info(self._session, self._robot)

    def command(self) -> Command:
        """Make a new command, which holds the home posture."""
        return Command(self.format.request)

    def tick(self, state: State, command: Command) -> Tick:
        """Torque for one state and command; waits for it.

        Args:
            command: What to do; its request vector takes the state.

        Returns:
            The tick; look at its status before using more than tau. Its torque
            keeps the command's ``limits.torque``, whoever answered.

        Raises:
            InvalidValue: If the service refused the numbers.
            ServiceUnreachable: If it did not answer before the patience was over.
            TwoServices: If another service says that it is the controller.
            LayoutMismatch: If the service was restarted with another formulation.
        """
        payload = self._pack(state, command)
        return self._limited(self._lock_step.ask(self._sequence, payload), command)

    def tick_within(self, state: State, command: Command, seconds: float) -> Tick | Missed:
        """Torque for one state and command if it comes in time; what is late is dropped.

        Args:
            command: What to do; its request vector takes the state.
            seconds: How long to wait at most.

        Returns:
            The tick as of ``tick``, or why there is none.

        Raises:
            TwoServices: If another service says that it is the controller.
            LayoutMismatch: If the service was restarted with another formulation.
        """
        end = time.monotonic() + seconds
        payload = self._pack(state, command)
        if not self._exchange.ask(self._sequence, payload, end):
            return Missed(Cause.LATE, "earlier questions are not answered either")
        missed = Missed(Cause.LATE)
        while True:
            has_come, reply = self._exchange.next(end)
            if not has_come:
                return missed
            if reply is None:  # no more replies to this question
                late = missed.cause is Cause.LATE
                return Missed(Cause.NOTHING_THERE) if late and not missed.detail else missed
            answer = self._belief.judge(reply, self._sequence)
            if not isinstance(answer, Missed):
                return self._limited(answer, command)
            missed = answer

    def _pack(self, state: State, command: Command) -> bytes:
        command.set_state(state)
        self._sequence += 1
        return pack_tick(REQUEST, self._belief.layout, self._sequence, command.request)

    def _limited(self, reply: Vector, command: Command) -> Tick:
        limit = command["limits.torque"]
        tau = reply[self._tau]
        np.clip(tau, -limit, limit, out=tau)
        return Tick(self.format, reply)
