"""A running client beside clients that do not read, and connections that say nothing.

Run: python -m benchmarks.crowd [--deaf N] [--frozen N] [--silent N] [--rounds N]
     [--seconds S] [--count-only] [--json FILE]

One client ticks 500 times a second, in turns alone, beside the crowd (see
``benchmarks.crowd_clients``), and beside one that asks for info and health ten times a
second each. Exit code 1 if a goal is missed: its worst tick beside the crowd at most
twice its worst alone, or 50 ms; its 99th percentile beside the questions at most 1.2
times that without them; no tick without an answer; a new client is let in.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import zenoh

from benchmarks.crowd_clients import ROBOT
from tsd_casadi.tick.command import Command
from tsd_casadi.wire.info import InfoMessage
from tsd_casadi.wire.keys import info_key, tick_key
from tsd_casadi.wire.tick_message import REPLY, REQUEST, pack_tick, unpack_tick
from tsd_clients.console.table import Column, console, print_table
from tsd_clients.remote.session import Session
from tsd_server.service_process import ServiceProcess, free_endpoint

PERIOD = 2e-3  # s
TIMEOUT = 0.5  # s
WORST_RATIO, WORST_ANYWAY = 2.0, 0.05  # 1, s
P99_RATIO = 1.2
# of one turn, while questions come and while they do not: the machine's own moods then
# meet both alike [s]
TURN = 1.0


@dataclass(frozen=True)
class Trips:
    """Round trips of one client.

    Attributes:
        count: How many.
        median, p99, worst: Of their durations [s].
        lost: Ticks without an answer.
    """

    count: int
    median: float
    p99: float
    worst: float
    lost: int


class TickingClient:
    """A client that ticks at a fixed rate and keeps the time of every round trip."""

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

    def __enter__(self) -> TickingClient:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the session."""
        self._session.close()

    def run(self, seconds: float) -> tuple[list[float], int]:
        """Tick for some seconds.

        Returns:
            The round trips [s], and how many had no answer.
        """
        trips, lost = [], 0
        due = time.monotonic()
        end = due + seconds
        while due < end:
            time.sleep(max(0.0, due - time.monotonic()))
            due = max(due + PERIOD, time.monotonic())
            start = time.perf_counter()
            lost += not self._is_answered()
            trips.append(time.perf_counter() - start)
        return trips, lost

    def _is_answered(self) -> bool:
        layout = self._format.layout_hash
        self._sequence += 1
        payload = pack_tick(REQUEST, layout, self._sequence, self._request)
        bodies = [
            reply.ok.payload.to_bytes() for reply in self._querier.get(payload=payload) if reply.ok
        ]
        if len(bodies) != 1:
            return False
        message = unpack_tick(bodies[0], REPLY, layout, self._format.reply.size)
        return message.sequence == self._sequence


class Crowd:
    """A process with clients of ``benchmarks.crowd_clients``."""

    def __init__(self, endpoint: str, **counts: int) -> None:
        """Start it; ``is_there`` says when all of them are."""
        options = [text for name, count in counts.items() for text in (f"--{name}", str(count))]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.crowd_clients", endpoint, *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.is_there = threading.Event()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        self._process.stdout.readline()
        self.is_there.set()

    def check(self) -> None:
        """Refuse to measure beside a crowd that is gone.

        Raises:
            RuntimeError: If it is.
        """
        if self._process.poll() is not None:
            raise RuntimeError(f"the crowd ended with exit code {self._process.returncode}")

    def freeze(self) -> None:
        """Freeze those that are to be."""
        assert self._process.stdin is not None
        self._process.stdin.write("freeze\n")
        self._process.stdin.flush()

    def end(self) -> None:
        """End it."""
        self._process.kill()
        self._process.communicate()


@contextmanager
def crowd_at(endpoint: str, client: TickingClient, **counts: int) -> Iterator[Crowd]:
    """Start a crowd beside a client that goes on ticking, and end it."""
    crowd = Crowd(endpoint, **counts)
    try:
        while not crowd.is_there.is_set():
            client.run(0.1)
        crowd.check()
        yield crowd
    finally:
        crowd.end()


def beside_a_crowd(
    endpoint: str, client: TickingClient, seconds: float, *, deaf: int, frozen: int, silent: int
) -> tuple[list[float], int]:
    """Tick while the crowd is there, and see whether a new client is let in."""
    with crowd_at(endpoint, client, deaf=deaf, frozen=frozen, silent=silent) as crowd:
        before, lost = client.run(seconds / 2)
        crowd.freeze()
        after, more = client.run(seconds / 2)
        crowd.check()
        with TickingClient(endpoint) as newcomer:
            _, lost_of_newcomer = newcomer.run(0.1)
    return before + after, lost + more + lost_of_newcomer


def measure(
    *, deaf: int, frozen: int, silent: int, rounds: int, seconds: float
) -> dict[str, Trips]:
    """Measure one client alone, beside the crowd and beside questions."""
    found: dict[str, list[tuple[list[float], int]]] = {}

    def keep(name: str, run: tuple[list[float], int]) -> None:
        found.setdefault(name, []).append(run)

    endpoint = free_endpoint()
    with ServiceProcess(["controller", "--listen", endpoint]), TickingClient(endpoint) as client:
        client.run(1.0)
        for _ in range(rounds):
            keep("alone", client.run(seconds))
            counts = {"deaf": deaf, "frozen": frozen, "silent": silent}
            keep("beside the crowd", beside_a_crowd(endpoint, client, seconds, **counts))
            client.run(1.0)  # until what is left of it is gone
            for _ in range(max(1, round(seconds / TURN))):
                keep("without questions", client.run(TURN))
                with crowd_at(endpoint, client, curious=1):
                    keep("beside questions", client.run(TURN))
    return {name: _summarize(runs) for name, runs in found.items()}


def _summarize(runs: list[tuple[list[float], int]]) -> Trips:
    trips = np.concatenate([each for each, _ in runs])
    median, p99 = (float(np.quantile(trips, share)) for share in (0.5, 0.99))
    return Trips(len(trips), median, p99, float(trips.max()), sum(lost for _, lost in runs))


def lost_ticks(found: dict[str, Trips]) -> list[str]:
    """List where ticks had no answer."""
    return [f"{each.lost} ticks lost {name}" for name, each in found.items() if each.lost]


def late_ticks(found: dict[str, Trips]) -> list[str]:
    """List the goals on time that were missed."""
    missed = []
    alone, crowd = found["alone"].worst, found["beside the crowd"].worst
    if crowd > max(WORST_RATIO * alone, WORST_ANYWAY):
        missed.append(f"worst tick {1e3 * crowd:.1f} ms beside the crowd, {1e3 * alone:.1f} alone")
    ratio = found["beside questions"].p99 / found["without questions"].p99
    if ratio > P99_RATIO:
        missed.append(f"99th percentile {ratio:.2f} times that without questions")
    return missed


def main() -> int:
    """Measure, print, and say whether the goals were met."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--deaf", type=int, default=10)
    parser.add_argument("--frozen", type=int, default=10)
    parser.add_argument("--silent", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--count-only", action="store_true", help="hold no time against a goal")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = vars(parser.parse_args())
    target, only_counts = given.pop("json"), given.pop("count_only")
    found = measure(**given)
    rows = list(found.values())
    columns = [Column("one client", list(found), is_text=True)]
    columns += [Column("ticks", [str(each.count) for each in rows])]
    for name in ("median", "p99", "worst"):
        columns.append(Column(f"{name}\nms", [f"{1e3 * getattr(each, name):.2f}" for each in rows]))
    columns.append(Column("lost", [str(each.lost) for each in rows]))
    print_table("round trips of ticks", columns)
    missed = lost_ticks(found) if only_counts else [*lost_ticks(found), *late_ticks(found)]
    console.print("; ".join(missed) or "every goal met", highlight=False)
    if target is not None:
        plain = {name: asdict(each) for name, each in found.items()}
        target.write_text(json.dumps({"runs": plain, "missed": missed}, indent=2) + "\n")
    return bool(missed)


if __name__ == "__main__":
    sys.exit(main())
