"""A running client beside clients that do not read, and connections that say nothing.

Run: python -m benchmarks.crowd [--deaf N] [--frozen N] [--silent N] [--seconds S] [--json FILE]

One client ticks at a fixed rate, alone and beside the crowd in turns. Shown are its
round trips, and the ticks without an answer. Exit code 1 if its worst tick beside the
crowd is more than twice the worst alone and more than 50 ms, or if a tick was lost.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import zenoh

from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.keys import info_key, tick_key
from tsd_casadi.wire.tick_message import REPLY, REQUEST, pack_tick, unpack_tick
from tsd_casadi.tick.command import Command
from tsd_clients.console.table import Column, console, print_table
from tsd_clients.remote.session import Session
from tsd_server.service_process import ServiceProcess, free_endpoint

ROBOT = "hermes_lower"
PERIOD = 2e-3  # s
TIMEOUT = 0.5  # s
ALLOWED = 2.0
ALLOWED_ANYWAY = 0.05  # s


class TickingClient:
    """A client that ticks at a fixed rate and keeps the time of every round trip.

    Attributes:
        trips: Round trips since the last ``take`` [s].
        lost: Ticks without an answer.
    """

    def __init__(self, endpoint: str) -> None:
        """Connect."""
        self._session = Session("controller", [endpoint])
        self._session.wait_for(ROBOT)
        info = InfoMessage.decode(self._session.query_one(info_key(ROBOT)))
        self._format = info.tick_format()
        self._request = Command(self._format.request).request
        self._querier: Any = self._session.zenoh.declare_querier(
            tick_key(ROBOT),
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=TIMEOUT,
            express=True,
        )
        self._sequence = 0
        self.lost = 0
        self.trips: list[float] = []

    def run(self, seconds: float) -> None:
        """Tick for some seconds."""
        due = time.monotonic()
        end = due + seconds
        while due < end:
            time.sleep(max(0.0, due - time.monotonic()))
            due = max(due + PERIOD, time.monotonic())
            self._tick()

    def _tick(self) -> None:
        layout = self._format.layout_hash
        self._sequence += 1
        payload = pack_tick(REQUEST, layout, self._sequence, self._request)
        start = time.perf_counter()
        replies = [reply for reply in self._querier.get(payload=payload) if reply.ok]
        self.trips.append(time.perf_counter() - start)
        if len(replies) != 1:
            self.lost += 1
            return
        body = replies[0].ok.payload.to_bytes()
        assert unpack_tick(body, REPLY, layout, self._format.reply.size).sequence == self._sequence

    def close(self) -> None:
        self._session.close()


@contextmanager
def crowd_at(endpoint: str, **counts: int) -> Iterator[subprocess.Popen[str]]:
    """Start a crowd as a process, and end it."""
    options = [part for name, count in counts.items() for part in (f"--{name}", str(count))]
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.crowd_clients", endpoint, *options],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        process.stdin.close()
        process.stdout.close()


def say_to(process, word, answer):
    if word:
        process.stdin.write(word + "\n")
        process.stdin.flush()
    got = process.stdout.readline().strip()
    assert got == answer, got


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--deaf", type=int, default=10)
    parser.add_argument("--frozen", type=int, default=10)
    parser.add_argument("--silent", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--low", action="store_true")
    given = parser.parse_args()
    endpoint = free_endpoint()
    with ServiceProcess(["controller", "--listen", endpoint]):
        client = TickingClient(endpoint)
        client.run(1.0)

        def report(name):
            t = np.array(client.trips) * 1e3
            print(
                f"{name:20s} n {len(t)} median {np.median(t):.2f} p99 {np.quantile(t, 0.99):.2f} worst {t.max():.2f} ms, lost {client.lost}",
                flush=True,
            )
            client.trips, client.lost = [], 0

        client.trips = []
        client.run(given.seconds)
        report("alone")
        for kind, n in (("silent", given.silent), ("deaf", given.deaf), ("frozen", given.frozen)):
            if not n:
                continue
            with crowd_at(endpoint, **{kind: n}) as process:
                start = time.monotonic()
                import threading

                th = threading.Thread(target=say_to, args=(process, "", "there"))
                th.start()
                while th.is_alive():
                    client.run(0.1)
                print(kind, "there after", time.monotonic() - start)
                if kind == "frozen":
                    say_to(process, "freeze", "asked")
                    process.send_signal(signal.SIGSTOP)
                client.run(given.seconds)
                report(kind)
                try:
                    s = time.monotonic()
                    c = TickingClient(endpoint)
                    c.run(0.1)
                    c.close()
                    print("  a new client in", time.monotonic() - s, c.lost)
                except Exception as e:
                    print("  new client:", repr(e))
            client.run(1.0)
            report("after " + kind)


if __name__ == "__main__":
    main()
