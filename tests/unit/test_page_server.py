"""Where the page is served, and that it does nothing for nobody."""

from __future__ import annotations

import socket

import pytest
import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from tsd_casadi.exceptions import InvalidValue
from tsd_clients.viewer.page import Page
from tsd_clients.viewer.page_server import LOOPBACK, open_server
from tsd_clients.viewer.panel import Panel


class Counted(Panel):
    """Counts; also a feed."""

    title = "Counted"

    def __init__(self) -> None:
        self.built, self.updates, self.polls = 0, 0, 0

    def build(self, server: viser.ViserServer) -> None:
        self.built += 1

    def update(self, now: float) -> None:
        self.updates += 1

    def poll(self, now: float) -> None:
        self.polls += 1

    def close(self) -> None:
        pass


def test_the_next_free_port_is_taken_and_only_this_machine_sees_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with socket.socket() as taken:
        taken.bind((LOOPBACK, 0))
        taken.listen()
        port = taken.getsockname()[1]
        server = open_server(LOOPBACK, port)
        try:
            assert port < server.get_port() <= port + 100
            assert server.get_host() == LOOPBACK
            # its way through the internet is closed
            assert server.request_share_url() is None
            counted = Counted()
            page = Page(server, [counted], [counted])
            page.update(0.0)
            # news is taken in, but nobody looks
            assert (counted.built, counted.polls, counted.updates) == (1, 1, 0)
        finally:
            server.stop()
    assert capsys.readouterr().out == ""


def test_an_address_of_another_machine_is_refused() -> None:
    # TEST-NET-1: nobody's
    with pytest.raises(InvalidValue, match=r"192\.0\.2\.1"):
        open_server("192.0.2.1", 8080)


def test_pages_from_elsewhere_are_refused() -> None:
    server = open_server(LOOPBACK, 8090)
    url = f"ws://{LOOPBACK}:{server.get_port()}"
    protocol = [Subprotocol(f"viser-v{viser.__version__}")]
    own = Origin(f"http://{LOOPBACK}:{server.get_port()}")
    try:
        connect(url, origin=own, subprotocols=protocol).close()
        with pytest.raises(InvalidStatus, match="403"):
            connect(url, origin=Origin("http://example.org"), subprotocols=protocol)
    finally:
        server.stop()
