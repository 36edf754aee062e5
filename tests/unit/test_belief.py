"""Every reply is a torque of the controller that is believed, or a cause."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tsd_casadi import InverseDynamics
from tsd_casadi.exceptions import (
    InvalidValue,
    LayoutMismatch,
    ServiceFailed,
    ServiceUnreachable,
    TsdError,
)
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.missed import Cause, Missed
from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.tick_message import REPLY, pack_tick
from tsd_clients.remote.belief import Belief

INSTANCE, RESTARTED, STRANGER = 5, 6, 7


@pytest.fixture(scope="module")
def tick_format(problem: InverseDynamics) -> TickFormat:
    return problem.format


def info(tick_format: TickFormat, instance: int) -> InfoMessage:
    return InfoMessage.of(
        tick_format,
        version="0",
        instance=instance,
        protocol=1,
        model="m",
        body="b",
        formulation="f",
        ticks_served=0,
        ticks_refused=0,
    )


class Session:
    """Passes replies on as they are, and answers ``info`` for one instance."""

    def __init__(self, tick_format: TickFormat) -> None:
        self.tick_format, self.instance = tick_format, INSTANCE

    def body_of(self, reply: Any) -> bytes:
        if isinstance(reply, Exception):
            raise reply
        assert isinstance(reply, bytes)
        return reply

    def query(self, key: str) -> list[bytes]:
        return [info(self.tick_format, self.instance).encode()]


@pytest.fixture
def session(tick_format: TickFormat) -> Session:
    return Session(tick_format)


@pytest.fixture
def belief(session: Session, tick_format: TickFormat) -> Belief:
    return Belief(session, tick_format.robot, info(tick_format, INSTANCE))  # type: ignore[arg-type]


def reply(
    tick_format: TickFormat, instance: int = INSTANCE, *, sequence: int = 3, value: float = 1.0
) -> bytes:
    values = np.full(tick_format.reply.size, value)
    return pack_tick(REPLY, tick_format.layout_hash, sequence, values, instance)


def looked(belief: Belief) -> None:
    assert belief._looking is not None
    belief._looking.join()


def test_the_torque_of_the_controller_is_taken(belief: Belief, tick_format: TickFormat) -> None:
    answer = belief.judge(reply(tick_format), 3)
    np.testing.assert_array_equal(answer, 1.0)


@pytest.mark.parametrize(
    ("error", "cause"),
    [
        (ServiceUnreachable("controller", ["here"], "Timeout"), Cause.LATE),
        (InvalidValue("q[0]", "nan", "a number"), Cause.REFUSED),
        (LayoutMismatch("layout 1", "layout 2"), Cause.REFUSED),
        (ServiceFailed("internal", "controller failed"), Cause.ERROR),
    ],
)
def test_what_the_service_says_instead_is_a_cause(
    belief: Belief, error: TsdError, cause: Cause
) -> None:
    answer = belief.judge(error, 3)
    assert isinstance(answer, Missed) and answer.cause is cause


def test_the_reply_to_another_question_is_an_error(belief: Belief, tick_format: TickFormat) -> None:
    answer = belief.judge(reply(tick_format, sequence=2), 3)
    assert isinstance(answer, Missed) and answer.cause is Cause.ERROR
    assert belief.foreign_replies == 0


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_none_are_an_error(
    belief: Belief, tick_format: TickFormat, value: float
) -> None:
    answer = belief.judge(reply(tick_format, value=value), 3)
    assert isinstance(answer, Missed) and answer.cause is Cause.ERROR
    looked(belief)
    assert belief.foreign_replies == 1


def test_a_stranger_is_not_believed(belief: Belief, tick_format: TickFormat) -> None:
    answer = belief.judge(reply(tick_format, STRANGER), 3)
    assert isinstance(answer, Missed) and answer.cause is Cause.ERROR
    looked(belief)
    assert (belief.instance, belief.foreign_replies) == (INSTANCE, 1)


def test_a_restarted_controller_is_believed_after_a_look(
    belief: Belief, session: Session, tick_format: TickFormat
) -> None:
    session.instance = RESTARTED
    assert isinstance(belief.judge(reply(tick_format, RESTARTED), 3), Missed)
    looked(belief)
    assert (belief.instance, belief.foreign_replies) == (RESTARTED, 0)
    np.testing.assert_array_equal(belief.judge(reply(tick_format, RESTARTED), 3), 1.0)
