"""Clients as a service wishes it had none: deaf, frozen and silent ones, and curious ones.

Run: python -m benchmarks.crowd_clients ENDPOINT [--deaf N] [--frozen N]
     [--silent N] [--curious N]

A *deaf* client keeps asking and keeps its session alive, and reads nothing: a relay
between it and the service stops taking what comes from the service. A *frozen* one is
deaf first, and once a line comes on the standard input its relay passes on nothing any
more, so the service gives it up with all that it has not read. A *silent* one is a TCP
connection that never says a word, and is made again whenever the service ends it. A
*curious* one asks for info and health and reads the answers. Says 'there' when all of
them are; ends when its standard input does.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import select
import selectors
import socket
import sys
import threading
import time
from contextlib import suppress
from typing import Any

import zenoh

from tsd_casadi.tick.command import Command
from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.keys import health_key, info_key, tick_key
from tsd_casadi.wire.session_settings import configure_runtime, session_settings
from tsd_casadi.wire.tick_message import REQUEST, pack_tick

ROBOT = "hermes_lower"
# a transport message of one byte, behind its length: "still there"
KEEP_ALIVE = b"\x01\x00\x04"
ALIVE_EVERY = 0.2  # s
# of the questions of one deaf or curious client [s]
PERIOD = 0.1
# so that a socket that nobody reads is full soon [bytes]
BUFFER = 8192
# of info, each time that a deaf client asks: so the two megabytes that queues and sockets
# hold are full after some seconds
INFOS = 3

Questions = list[tuple[str, bytes | None]]


class DeafRelay:
    """Relays one client's words to the service, and nothing back once told to go deaf.

    Attributes:
        is_deaf: Set to take nothing from the service any more.
        is_frozen: Set to take nothing from the client either.
    """

    def __init__(self, service: tuple[str, int]) -> None:
        """Listen on a free port of this machine."""
        self._service = service
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.endpoint = f"tcp/127.0.0.1:{self._listening.getsockname()[1]}"
        self.is_deaf, self.is_frozen = threading.Event(), threading.Event()
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
                if self.is_frozen.is_set():
                    threading.Event().wait()
                for source in select.select(reading, [], [], ALIVE_EVERY)[0]:
                    words = source.recv(65536)
                    if not words:
                        return
                    (service if source is client else client).sendall(words)
                if self.is_deaf.is_set():
                    client.sendall(KEEP_ALIVE)


def open_client(endpoint: str) -> Any:
    """Open a session as any client does."""
    configure_runtime()
    settings = session_settings(connect=[endpoint])
    return zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))


def answers_to(session: Any, key: str) -> list[bytes]:
    """Ask once, and list the bodies of what is answered."""
    replies = session.get(key, timeout=1.0)
    return [reply.ok.payload.to_bytes() for reply in replies if reply.ok]


def questions_for(sessions: list[Any]) -> Questions:
    """List what a deaf client asks for; every session has been answered then."""
    request = b""
    for session in sessions:
        while not (bodies := answers_to(session, info_key(ROBOT))):
            time.sleep(0.05)  # its link is not there yet
        info = InfoMessage.decode(bodies[0]).tick_format()
        request = pack_tick(REQUEST, info.layout_hash, 1, Command(info.request).request)
    return [*[(info_key(ROBOT), None)] * INFOS, (tick_key(ROBOT), request)]


def keep_asking(session: Any, questions: Questions, *, reads: bool) -> None:
    """Ask for ever, and look at the answers or not."""
    waiting = threading.Event()
    while not waiting.wait(PERIOD):
        for key, payload in questions:
            with suppress(zenoh.ZError):
                replies = session.get(key, payload=payload, timeout=1.0)
                if reads:
                    list(replies)


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
            selector.register(silent, selectors.EVENT_READ, silent)
            missing -= 1
        if not missing:
            there.set()
        for key, _ in selector.select(0.05):
            # nothing is ever sent to it, so it has been closed
            selector.unregister(key.data)
            key.data.close()
            missing += 1


def main() -> None:
    """Be there until the standard input ends."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("endpoint")
    for name in ("deaf", "frozen", "silent", "curious"):
        parser.add_argument(f"--{name}", type=int, default=0)
    given = parser.parse_args()
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    host, port = given.endpoint.removeprefix("tcp/").rsplit(":", 1)
    service, there = (host, int(port)), threading.Event()
    relays = [DeafRelay(service) for _ in range(given.deaf + given.frozen)]
    deaf = [open_client(relay.endpoint) for relay in relays]
    curious = [open_client(given.endpoint) for _ in range(given.curious)]
    questions = questions_for([*deaf, *curious])
    for relay in relays:
        relay.is_deaf.set()
    asked = [(info_key(ROBOT), None), (health_key(ROBOT, "controller"), None)]
    for sessions, about, reads in ((deaf, questions, False), (curious, asked, True)):
        for session in sessions:
            threading.Thread(
                target=keep_asking, args=(session, about), kwargs={"reads": reads}, daemon=True
            ).start()
    if given.silent:
        arguments = (service, given.silent, there)
        threading.Thread(target=stay_silent, args=arguments, daemon=True).start()
        there.wait()
    print("there", flush=True)
    if sys.stdin.readline():
        for relay in relays[: given.frozen]:
            relay.is_frozen.set()
        sys.stdin.readline()
    os._exit(0)  # what does not read cannot be closed in order


if __name__ == "__main__":
    main()
