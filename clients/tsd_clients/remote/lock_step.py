"""A tick is asked until it is answered; simulated time stands still meanwhile."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Sequence
from typing import Any

import zenoh

from tsd_casadi.exceptions import ServiceUnreachable, TsdError
from tsd_casadi.state import Vector
from tsd_casadi.tick.missed import Cause, Missed
from tsd_clients.remote.belief import Belief

TICK_TIMEOUT = 0.5  # s
# between two questions while nobody is there [s]
RETRY = 0.02
# a pause that a user notices and wants explained [s]
NOTICEABLE = 1.0

_log = logging.getLogger(__name__)


class LockStep:
    """Asks and waits.

    Attributes:
        waited: For answers that did not come at once [s], by cause.
    """

    def __init__(
        self, querier: Any, belief: Belief, endpoints: Sequence[str], patience: float
    ) -> None:
        """Use a declared querier.

        Args:
            endpoints: Where the controller is looked for.
            patience: How long a tick is asked again [s].
        """
        self._querier, self._belief = querier, belief
        self._endpoints, self._patience = endpoints, patience
        self.waited = dict.fromkeys(Cause, 0.0)

    def ask(self, sequence: int, payload: bytes) -> Vector:
        """Give the numbers of the reply to one question.

        Args:
            sequence: Number of the question.

        Raises:
            TsdError: What the service refused; see ``RemoteController.tick``.
        """
        answer = self._ask_once(sequence, payload)
        if isinstance(answer, Missed):
            return self._ask_again(sequence, payload, answer)
        return answer

    def _ask_once(self, sequence: int, payload: bytes) -> Vector | Missed:
        """Find the reply of the instance that is believed, or tell why it has to be asked again.

        Raises:
            TsdError: If the service refused.
        """
        strangers: list[int] = []
        refusal: TsdError | None = None
        missed = Missed(Cause.NOTHING_THERE)
        try:
            for reply in self._querier.get(payload=payload):
                try:
                    message = self._belief.read(reply)
                except ServiceUnreachable:
                    # timed out: who refused need not be the controller
                    refusal, missed = None, Missed(Cause.LATE, f"no reply in {TICK_TIMEOUT:g} s")
                    continue
                except TsdError as error:
                    refusal = error  # names no instance, so a torque goes before it
                    continue
                if message is None or message.instance != self._belief.instance:
                    strangers.append(0 if message is None else message.instance)
                elif message.sequence == sequence:
                    self._belief.drop(strangers)
                    return message.values.copy()
        except zenoh.ZError:
            refusal = None  # closed without a reply
        if refusal is not None:
            raise refusal
        if strangers:
            missed = Missed(Cause.ERROR, "only replies that are not of the controller")
            if self._belief.has_restarted():
                strangers = [each for each in strangers if each != self._belief.instance]
        self._belief.drop(strangers)
        return missed

    def _ask_again(self, sequence: int, payload: bytes, why: Missed) -> Vector:
        """Ask until there is an answer or the patience is over; says in the log what for."""
        answer: Vector | Missed = why
        start = last = time.monotonic()
        waited: dict[Cause, float] = {}
        is_told = False
        while isinstance(answer, Missed):
            why = answer
            time.sleep(RETRY)
            answer = self._ask_once(sequence, payload)
            now = time.monotonic()
            self.waited[why.cause] += now - last
            waited[why.cause] = waited.get(why.cause, 0.0) + now - last
            last = now
            if not isinstance(answer, Missed):
                break
            if now - start > self._patience:
                raise ServiceUnreachable(
                    "controller",
                    self._endpoints,
                    f"waited {self._patience:g} s for a reply, "
                    + ", ".join(f"{cause.words} {each:.1f} s" for cause, each in waited.items()),
                )
            if not is_told and now - start > NOTICEABLE:
                limit = "" if math.isinf(self._patience) else f" for up to {self._patience:g} s"
                at = ", ".join(self._endpoints)
                _log.warning("waiting%s for the controller at %s: %s", limit, at, answer)
                is_told = True
        return answer
