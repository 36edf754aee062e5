"""The process that publishes a run: ``python -m tsd_clients.telemetry.publisher ROBOT INSTANCE``.

A process of its own, so that nobody who watches, and nothing that a stranger sends,
takes time from the run: what it is told comes through a pipe that the run never waits
for. It loads Zenoh and nothing else that is slow, and ends with its run.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import socket
import sys
import threading
from contextlib import suppress
from typing import Any

import zenoh
from zenoh.handlers import FifoChannel, RingChannel

from tsd_casadi.wire import keys
from tsd_casadi.wire.quick_close import no_waiting_closes
from tsd_casadi.wire.session_settings import configure_runtime, session_settings
from tsd_clients.telemetry.feed import ROWS, read_feed
from tsd_clients.telemetry.kept_events import KeptEvents

JSON = zenoh.Encoding.APPLICATION_JSON
# the run and its controller go first
NICENESS = 5
# of a port that is free when it is looked for and taken when it is listened on
ATTEMPTS = 10
# questions for the story that wait; of more the oldest are dropped, and asked again
WAITING = 64
# of events about links; more of them at once wait
EVENTS = 1024
# how long closing may take: a viewer that is frozen with a full pipe blocks it [s]
CLOSING = 0.5


class Publisher:
    """A session that tells whoever subscribes what it is fed.

    Attributes:
        endpoint: Where it listens.
    """

    def __init__(self, robot: str, instance: int) -> None:
        """Open the session on a port of loopback that the system chooses.

        Args:
            robot: Robot's chunk of the keys.
            instance: Id of the run.

        Raises:
            zenoh.ZError: If nothing can be listened on.
        """
        self._kept = KeptEvents()
        self._session, self.endpoint = _open()
        self._links: Any = self._session.info.declare_link_events_listener(
            FifoChannel(EVENTS), history=True
        )
        # what a viewer has no room for is dropped there; it asks for the story then
        drop = zenoh.CongestionControl.DROP
        self._rows: Any = self._session.declare_publisher(
            keys.rows_key(robot, instance), congestion_control=drop
        )
        self._events: Any = self._session.declare_publisher(
            keys.events_key(robot, instance), congestion_control=drop, encoding=JSON
        )
        self._story_key = keys.story_key(robot, instance)
        self._asked: Any = self._session.declare_queryable(
            self._story_key, RingChannel(WAITING), complete=True
        )
        self._token = self._session.liveliness().declare_token(keys.run_alive_key(robot, instance))
        for task in (self._watch_links, self._tell):
            threading.Thread(target=task, daemon=True).start()

    def publish(self, tag: bytes, body: bytes) -> None:
        """Publish rows or an event; nobody is waited for."""
        if tag == ROWS:
            self._rows.put(body)
        else:
            self._kept.keep(body)
            self._events.put(body)

    def end(self) -> None:
        """Say that the run is over, if it did not say so itself, and close."""
        kept = self._kept
        if not kept.is_over:
            over = {
                "number": kept.number + 1,
                "repetition": kept.repetition,
                "event": "over",
                "reason": "its process ended in the middle of it",
            }
            self._events.put(json.dumps(over))
        closing = threading.Thread(target=self._session.close, daemon=True)
        closing.start()
        closing.join(CLOSING)

    def _tell(self) -> None:
        with suppress(zenoh.ZError):
            for query in self._asked:  # ends when the session is closed
                with query, suppress(zenoh.ZError):
                    query.reply(self._story_key, self._kept.story(), encoding=JSON)

    def _watch_links(self) -> None:
        with suppress(zenoh.ZError):
            for event in self._links:
                if event.kind == zenoh.SampleKind.PUT:
                    no_waiting_closes(event.link.src)


def _open() -> tuple[Any, str]:
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    with suppress(OSError, ValueError):
        # each connection is a file
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    configure_runtime()
    zenoh.init_log_from_env_or("off")
    for attempt in range(ATTEMPTS):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
        settings = session_settings(listen=[endpoint], service="run")
        try:
            return zenoh.open(zenoh.Config.from_json5(json.dumps(settings))), endpoint
        except zenoh.ZError:
            if attempt == ATTEMPTS - 1:
                raise
    raise AssertionError


def main() -> None:
    """Publish what comes through stdin until its other end is closed."""
    parent = os.getppid()
    # Ctrl-C is meant for the run, which then says what came of it
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(OSError):
        os.nice(NICENESS)
    publisher = Publisher(sys.argv[1], int(sys.argv[2]))
    print(publisher.endpoint, flush=True)
    for tag, body in read_feed(0, parent):
        publisher.publish(tag, body)
    publisher.end()
    # threads of Zenoh would keep the interpreter from ending
    os._exit(0)


if __name__ == "__main__":
    main()
