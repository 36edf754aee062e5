"""A TCP link between client and service that can be cut, silenced or slowed down."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import suppress
from queue import SimpleQueue

CHUNK = 65536


class Link:
    """Forwards connections; both ends are on this computer.

    Attributes:
        endpoint: Where a client connects.
        delay: Added to everything, in each direction [s].
    """

    def __init__(self, service: str) -> None:
        """Listen on a free port.

        Args:
            service: Endpoint of the service, tcp/ADDRESS:PORT.
        """
        host, port = service.removeprefix("tcp/").rsplit(":", 1)
        self._service = (host, int(port))
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.endpoint = f"tcp/127.0.0.1:{self._listener.getsockname()[1]}"
        self.delay = 0.0
        self._passes = threading.Event()
        self._passes.set()
        self._is_cut = False
        self._sockets: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def __enter__(self) -> Link:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close everything."""
        self.cut()
        self._listener.close()

    def cut(self) -> None:
        """Close all connections and every new one, as if the service's computer had gone."""
        self._is_cut = True
        self._passes.set()
        for each in self._sockets:
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
        self._sockets.clear()

    def silence(self) -> None:
        """Pass nothing on, as a cable that was pulled: nobody is told."""
        self._passes.clear()

    def mend(self) -> None:
        """Be a good link again."""
        self._is_cut, self.delay = False, 0.0
        self._passes.set()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                try:
                    if self._is_cut:
                        raise ConnectionError
                    service = socket.create_connection(self._service)
                except OSError:
                    client.close()
                    continue
                self._sockets += [client, service]
                for source, target in ((client, service), (service, client)):
                    source.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    chunks: SimpleQueue[tuple[float, bytes]] = SimpleQueue()
                    for work, end in ((self._read, source), (self._write, target)):
                        threading.Thread(target=work, args=(end, chunks), daemon=True).start()

    def _read(self, source: socket.socket, chunks: SimpleQueue[tuple[float, bytes]]) -> None:
        chunk = b" "
        while chunk:
            try:
                chunk = source.recv(CHUNK)
            except OSError:
                chunk = b""
            chunks.put((time.monotonic() + self.delay, chunk))

    def _write(self, target: socket.socket, chunks: SimpleQueue[tuple[float, bytes]]) -> None:
        with suppress(OSError):
            while True:
                due, chunk = chunks.get()
                time.sleep(max(0.0, due - time.monotonic()))
                self._passes.wait()
                if not chunk:
                    break
                target.sendall(chunk)
        with suppress(OSError):
            target.shutdown(socket.SHUT_RDWR)
