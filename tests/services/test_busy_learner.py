"""A learner that is there but at work is not told from one that is missing by its silence alone."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest
import zenoh

from tsd_casadi.exceptions import ServiceBusy, ServiceUnreachable
from tsd_casadi.wire.keys import ANY_ROBOT, alive_key, database_key, record_key
from tsd_casadi.wire.session_settings import session_settings
from tsd_clients.remote.session import Session
from tsd_server.service_process import free_endpoint

KEY = record_key("hermes_lower")


@pytest.fixture
def endpoint() -> Iterator[str]:
    """Where a learner says that it is there, takes questions and answers none of them."""
    endpoint = free_endpoint()
    settings = session_settings(listen=[endpoint], service="learner")
    session = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
    kept = []
    parts = [
        session.liveliness().declare_token(alive_key(ANY_ROBOT, "learner")),
        session.declare_queryable(KEY, kept.append, complete=True),
        session.declare_queryable(database_key(ANY_ROBOT), kept.append, complete=True),
    ]
    yield endpoint
    del parts, kept
    session.close()  # type: ignore[no-untyped-call]


def test_a_learner_at_work_is_not_said_to_be_missing(endpoint: str) -> None:
    session = Session("learner", [endpoint])
    try:
        session.wait_for(ANY_ROBOT)
        with pytest.raises(ServiceBusy, match=r"is there but did not answer within 0\.3 s") as busy:
            session.query_one(KEY, payload=b"{}", timeout=0.3)
        assert "'tsd database list'" in str(busy.value)
        assert "start one" not in str(busy.value)
        # who catches any silence catches this one
        with pytest.raises(ServiceUnreachable):
            session.query(database_key(ANY_ROBOT), timeout=0.3)
    finally:
        session.close()
