"""Clients as a service wishes it had none: deaf, frozen and silent ones.

Run: python -m benchmarks.crowd_clients ENDPOINT [--deaf N] [--frozen N] [--silent N]

A *deaf* client keeps asking and keeps its session alive, and reads nothing: a relay
between it and the service stops taking what comes from the service. A *frozen* one
has asked for more than fits into its socket and does not run any more; this process
is to be stopped with SIGSTOP for that. A *silent* one is a TCP connection that never
says a word, and is made again whenever the service ends it. Says 'there' when all of
them are; ends when its standard input does.
"""

from __future__ import annotations

import argparse
import json
import resource
import select
import selectors
import socket
import sys
import threading
from contextlib import suppress
from typing import Any

import zenoh

from tsd_casadi.wire.session_settings import configure_runtime, session_settings
from tsd_casadi.tick.command import Command
from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.keys import info_key, tick_key
from tsd_casadi.wire.tick_message import REQUEST, pack_tick

Questions = list[tuple[str, bytes | None]]

# a transport message of one byte, behind its length: "still there"
KEEP_ALIVE = b"\x01\x00\x04"
ALIVE_EVERY = 0.2  # s
# of the questions of one deaf client [s]; info is the largest answer of a controller
PERIOD = 0.1
# so that a socket that nobody reads is full soon [bytes]
BUFFER = 8192
# more than queues and sockets between two sessions hold, of info
BURST = 400


class DeafRelay:
    """Relays one client's words to the service, and nothing back once told to go deaf."""

    def __init__(self, service: tuple[str, int]) -> None:
        """Listen on a free port of this machine."""
        self._service = service
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.endpoint = f"tcp/127.0.0.1:{self._listening.getsockname()[1]}"
        self.is_deaf = threading.Event()
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            client, _ = self._listening.accept()
            threading.Thread(target=self._relay, args=(client,), daemon=True).start()

    def _relay(self, client: socket.socket) -> None:
        with client, socket.socket() as service, suppress(OSError):
            service.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
            service.connect(self._service)
            while True:
                reading = [client] if self.is_deaf.is_set() else [client, service]
                ready = select.select(reading, [], [], ALIVE_EVERY)[0]
                for source in ready:
                    words = source.recv(65536)
                    if not words:
                        return
                    (service if source is client else client).sendall(words)
                if self.is_deaf.is_set():
                    client.sendall(KEEP_ALIVE)


def open_client(endpoint: str) -> zenoh.Session:
    """Open a session as any client does."""
    configure_runtime()
    return zenoh.open(zenoh.Config.from_json5(json.dumps(session_settings(connect=[endpoint]))))


def keep_asking(session: Any, asked: Questions, over: threading.Event) -> None:
    """Ask, and look at no answer."""
    while not over.wait(PERIOD):
        for key, payload in asked:
            with suppress(zenoh.ZError):
                session.get(key, zenoh.handlers.RingChannel(1), payload=payload, timeout=1.0)


def stay_silent(service: tuple[str, int], count: int, there: threading.Event) -> None:
    """Hold connections open without a word."""
    selector = selectors.DefaultSelector()
    missing = count
    while True:
        while missing:
            silent = socket.socket()
            try:
                silent.settimeout(1.0)
                silent.connect(service)
            except OSError:
                silent.close()
                break
            selector.register(silent, selectors.EVENT_READ)
            missing -= 1
        if not missing:
            there.set()
        for key, _ in selector.select(0.05):
            # nothing is ever sent to it, so it has been closed
            selector.unregister(key.fileobj)
            key.fileobj.close()  # type: ignore[union-attr]
            missing += 1


def main() -> None:
    """Be there until the standard input ends."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("endpoint")
    parser.add_argument("--robot", default="hermes_lower")
    for name in ("deaf", "frozen", "silent"):
        parser.add_argument(f"--{name}", type=int, default=0)
    given = parser.parse_args()
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    host, port = given.endpoint.removeprefix("tcp/").rsplit(":", 1)
    service, key = (host, int(port)), info_key(given.robot)
    over, there = threading.Event(), threading.Event()
    relays = [DeafRelay(service) for _ in range(given.deaf)]
    deaf = [open_client(relay.endpoint) for relay in relays]
    frozen = [open_client(given.endpoint) for _ in range(given.frozen)]
    asked = [(key, None)]
    for session in (*deaf, *frozen):
        reply = next(iter(session.get(key, timeout=5.0))).ok
        info = InfoMessage.decode(reply.payload.to_bytes())
    if deaf or frozen:
        form = info.tick_format()
        request = Command(form.request).request
        asked.append((tick_key(given.robot), pack_tick(REQUEST, form.layout_hash, 1, request)))
    for relay in relays:
        relay.is_deaf.set()
    for session in deaf:
        threading.Thread(target=keep_asking, args=(session, asked, over), daemon=True).start()
    if given.silent:
        threading.Thread(
            target=stay_silent, args=(service, given.silent, there), daemon=True
        ).start()
        there.wait()
    print("there", flush=True)
    sys.stdin.readline()  # 'freeze', or the end
    pending = [
        session.get(key, zenoh.handlers.RingChannel(1), payload=payload, timeout=5.0)
        for _ in range(BURST)
        for session in frozen
        for key, payload in asked
    ]
    print("asked", flush=True)
    sys.stdin.readline()
    del pending
    sys.stdout.flush()
    over.set()
    import os

    os._exit(0)  # sessions whose peer is gone need not be closed


if __name__ == "__main__":
    main()
