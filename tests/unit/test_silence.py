"""Whoever is silent is named; whoever is there and was not asked is not blamed for it."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator

import pytest

from tsd_casadi.exceptions import ServiceBusy
from tsd_casadi.wire.run_record import RunRecord
from tsd_clients.remote import silence
from tsd_clients.remote.silence import explain_silence, silence_of


@pytest.fixture
def endpoint() -> Iterator[str]:
    """Where something takes connections and says nothing."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"tcp/127.0.0.1:{server.getsockname()[1]}"


@pytest.fixture(autouse=True)
def there(monkeypatch: pytest.MonkeyPatch, endpoint: str) -> RunRecord:
    """A controller that runs there."""
    record = RunRecord.of_this_process(
        "controller", "biped", robot="biped", endpoints=(endpoint,), instance=1
    )
    monkeypatch.setattr(silence, "running", lambda: [record])
    return record


def test_a_service_of_another_kind_is_not_said_to_be_frozen(endpoint: str) -> None:
    told = explain_silence("learner", [endpoint])
    assert told == f"at {endpoint} is the controller, process {os.getpid()}"
    for role in ("controller", "*"):
        assert "is starting or frozen" in explain_silence(role, [endpoint])


def test_a_frozen_controller_says_nothing_of_the_learner(
    monkeypatch: pytest.MonkeyPatch, endpoint: str
) -> None:
    monkeypatch.setattr(silence, "is_stopped", lambda pid: True)
    busy = silence_of("learner", [endpoint], "no reply", 3.0)
    assert isinstance(busy, ServiceBusy)
    frozen = silence_of("controller", [endpoint], "no reply", 3.0)
    assert not isinstance(frozen, ServiceBusy)
    assert "kill -CONT" in str(frozen) and "kill -CONT" not in str(busy)
