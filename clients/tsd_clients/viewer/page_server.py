"""The server of the page: one that only this machine reaches, and that asks nobody else."""

from __future__ import annotations

import contextlib
import io
import socket
from collections.abc import Iterator
from functools import partial
from typing import Any

import viser
import websockets.asyncio.server

from tsd_casadi.exceptions import InvalidValue

LOOPBACK = "127.0.0.1"
PORT = 8080
# ports tried after the one that is taken
NEXT = 100
LABEL = "tsd"
# of the panel, beside the robots [pixels]
WIDTH = 440


class PageServer(viser.ViserServer):
    """Viser without its way through the internet, and silent about itself."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: what a robot does is shown to nobody outside."""
        return None

    def stop(self) -> None:
        """Stop serving."""
        with contextlib.redirect_stdout(io.StringIO()):
            super().stop()


def open_server(host: str, port: int) -> PageServer:
    """Open the server of a page.

    Args:
        host: Where it listens; other machines see it unless it is ``LOOPBACK``.
        port: The first one tried; the next free one is taken.

    Raises:
        InvalidValue: If it cannot listen there.
    """
    free = _free_port(host, port)
    own = _only_own_pages(host, free) if host == LOOPBACK else contextlib.nullcontext()
    # it would draw a box with its addresses
    with own, contextlib.redirect_stdout(io.StringIO()):
        server = PageServer(host=host, port=free, label=LABEL, verbose=False)
    server.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(40, 90, 160))
    server.gui.main_panel.dock_right()
    server.gui.main_panel.set_width(WIDTH)
    return server


@contextlib.contextmanager
def _only_own_pages(host: str, port: int) -> Iterator[None]:
    """Make a server that is opened meanwhile refuse what other pages send.

    A browser lets any page talk to this machine's loopback and says which page it was;
    viser does not ask, and a page from anywhere could press the buttons of this one.
    """
    # viser, which brings this library, looks it up there when it starts
    module: Any = websockets.asyncio.server
    serve = module.serve
    # programs say nothing, and are this machine's own
    origins: list[Any] = [None, *(f"http://{name}:{port}" for name in (host, "localhost"))]
    module.serve = partial(serve, origins=origins)
    try:
        yield
    finally:
        module.serve = serve


def _free_port(host: str, port: int) -> int:
    reason: OSError | None = None
    for candidate in range(port, min(port + NEXT, 2**16)):
        with socket.socket() as probe:
            # as the server does: the port of a page that was just closed is free
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((host, candidate))
            except OSError as error:
                reason = error
            else:
                return candidate
    raise InvalidValue(
        "address of the page",
        f"{host}:{port} ({'no such port' if reason is None else reason.strerror})",
        f"an address of this machine with a free port from {port} on",
    )
