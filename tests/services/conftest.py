from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tsd_clients.remote.session import Session


@pytest.fixture
def raw_session(endpoint: str) -> Iterator[Any]:
    """A ``zenoh.Session`` that sees the service of the module's ``endpoint``."""
    session = Session("*", [endpoint])
    try:
        session.wait_for("*")
        yield session.zenoh
    finally:
        session.close()
