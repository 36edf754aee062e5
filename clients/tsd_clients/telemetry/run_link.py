"""The connection of somebody who watches to a run: never waited for."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import zenoh
from zenoh.handlers import FifoChannel, RingChannel

from tsd_casadi.wire import keys
from tsd_casadi.wire.run_record import RunRecord
from tsd_casadi.wire.session_settings import configure_runtime, session_settings

# of messages, 25 a second: a page that stands still for 10 s misses nothing
WAITING = 256
# for the story [s]; asked again without it
ANSWER = 1.0
# between two questions for it [s]
PAUSE = 0.2


class RunLink:
    """Subscribes to a run and asks for its story, in Zenoh's threads and one for connecting.

    Attributes:
        is_there: Whether the run's publishing process is.
    """

    def __init__(self, record: RunRecord) -> None:
        """Begin to connect."""
        self.is_there = False
        self._record = record
        self._parts: tuple[Any, Any, Any] | None = None
        self._is_closed = False
        self._replies: Any = None
        self._asked = 0.0
        self._start(self._connect)

    def close(self) -> None:
        """Close the connection in the background: a frozen run would be waited for."""
        self._is_closed = True
        if self._parts is not None:
            self._start(self._parts[0].close)

    def look(self) -> bool:
        """Look whether the run is there; says whether it came, or came back, since last time."""
        came = False
        if self._parts is not None:
            while (sample := self._parts[2].try_recv()) is not None:
                self.is_there = sample.kind == zenoh.SampleKind.PUT
                came = self.is_there
        return came

    def messages(self) -> Iterator[tuple[str, bytes]]:
        """Take what has come: last word of the key, and the body."""
        if self._parts is not None:
            while (sample := self._parts[1].try_recv()) is not None:
                yield str(sample.key_expr).rpartition("/")[2], bytes(sample.payload.to_bytes())

    def ask(self) -> None:
        """Ask for the story, unless that was just done."""
        now = time.monotonic()
        if self._parts is None or self._replies is not None or now - self._asked < PAUSE:
            return
        self._asked = now
        key = keys.story_key(self._record.robot, self._record.instance)
        self._replies = self._parts[0].get(key, handler=FifoChannel(4), timeout=ANSWER)

    def story(self) -> bytes | None:
        """Take the story, if it has come since it was asked for."""
        if self._replies is None:
            return None
        try:
            reply = self._replies.try_recv()
        except zenoh.ZError:  # closed without an answer
            self._replies = None
            return None
        if reply is None or reply.ok is None:
            return None
        self._replies = None
        return bytes(reply.ok.payload.to_bytes())

    def _start(self, task: Callable[[], None]) -> None:
        # the interpreter waits for it, a second or so at the most: in the middle of Zenoh
        # it would end with a crash
        threading.Thread(target=task).start()

    def _connect(self) -> None:
        record = self._record
        configure_runtime()
        zenoh.init_log_from_env_or("off")
        settings = session_settings(connect=record.endpoints)
        try:
            session: Any = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
        except zenoh.ZError:
            return
        alive = keys.run_alive_key(record.robot, record.instance)
        there = session.liveliness().declare_subscriber(
            alive, handler=RingChannel(WAITING), history=True
        )
        # rows and events in one, so that they stay in order
        every = keys.rows_key(record.robot, record.instance).rpartition("/")[0] + "/*"
        samples = session.declare_subscriber(every, RingChannel(WAITING))
        self._parts = (session, samples, there)
        if self._is_closed:
            session.close()
