"""What a question costs a learner that knows much, against one that knows little.

Run: python -m benchmarks.learner [--entries 10 1000 100000] [--queries N] [--json FILE]

A service for each number of entries and one that only echoes take turns, in one run:
an exact query against an echo of as many bytes with the same selector, of entries
that were asked for before ('exact'), of what was recorded just before ('after') and of
random ones among all ('first': where there are more than a learner keeps decoded, most have
to be read); a recording of new parameters and one of parameters that are known; opening the
file; the list of a thousand entries as the client gets it, the usual page of it ('page') and
all, and 'tsd database list' with both, as commands. What starts the interpreter and loads its
modules for any command of the network is 'its start'. Time is the wall's: medians, and what a
machine with less to do would show.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

from benchmarks.filled_database import ROBOT, fill, recording, squat
from tsd_casadi.database.database import Database
from tsd_casadi.wire.keys import feedforward_key
from tsd_casadi.wire.question import question_texts
from tsd_casadi.wire.session_settings import session_settings
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_clients.remote.session import Session
from tsd_server.service_process import ServiceProcess, free_endpoint

LISTED = 1_000
RECORDINGS = 40
OPENINGS = 5
USUAL_PAGE = 40
# entries that are asked for over and over
USUAL = 100
# a queryable with a channel and a thread, as the services have, that answers with bytes
ECHO = """
import sys, zenoh
config = zenoh.Config.from_json5(sys.argv[1])
body = b"x" * int(sys.argv[2])
with zenoh.open(config) as session:
    queryable = session.declare_queryable("tsd/*/learner/*", zenoh.handlers.RingChannel(64))
    print("ready", flush=True)
    for query in queryable:
        with query:
            query.reply(str(query.key_expr), body)
"""

Asking = Callable[[], object]


@contextmanager
def echo(size: int) -> Iterator[str]:
    """Run a process that echoes, and give its endpoint.

    Args:
        size: Of its replies [bytes].
    """
    endpoint = free_endpoint()
    settings = json.dumps(session_settings(listen=[endpoint], service="learner"))
    command = [sys.executable, "-c", ECHO, settings, str(size)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield endpoint
        finally:
            process.kill()


def in_turns(asking: dict[str, Asking], rounds: int) -> dict[str, list[float]]:
    """Time several things in turns, so that what else the machine does hits all alike [s]."""
    times: dict[str, list[float]] = {name: [] for name in asking}
    for ask in asking.values():
        ask()
    names, chance = list(asking), random.Random(1)
    for _ in range(rounds):
        chance.shuffle(names)  # who comes after whom counts: processes and caches wake up
        for name in names:
            before = perf_counter()
            asking[name]()
            times[name].append(perf_counter() - before)
    return times


def measure(folder: Path, counts: list[int], queries: int) -> dict[str, Any]:
    """Measure all.

    Args:
        folder: For the files.
        counts: Numbers of entries, the smallest first.
        queries: Number of exact queries of each.
    """
    paths = {count: folder / f"{count}.sqlite" for count in {*counts, LISTED}}
    for count, path in paths.items():
        fill(path, count)
    with ExitStack() as stack:
        sessions = {}
        for count, path in paths.items():
            endpoint = free_endpoint()
            options = ["learner", "--database", str(path), "--listen", endpoint]
            stack.enter_context(ServiceProcess(options))
            sessions[count] = stack.enter_context(RemoteLearner([endpoint]))
            if count == LISTED:
                listed = endpoint
        chance = random.Random(0)

        usual = {n: [chance.randint(1, n) for _ in range(USUAL)] for n in counts}

        def asks(session: Session, number: int) -> bytes:
            parameters = squat(number)
            selector = question_texts("squat", parameters, version=None, axes=None, context=None)
            return session.query_one(feedforward_key(ROBOT), parameters=selector)

        size = len(asks(sessions[counts[0]]._session, 1))
        bare = Session("learner", [stack.enter_context(echo(size))])
        stack.callback(bare.close)
        for n in counts:
            for number in usual[n]:
                asks(sessions[n]._session, number)
        asking: dict[str, Asking] = {"echo": lambda: asks(bare, 1)}
        asking |= {
            f"exact {n}": lambda n=n: asks(sessions[n]._session, chance.choice(usual[n]))  # type: ignore[misc]
            for n in counts
        }
        asking |= {
            f"first {n}": lambda n=n: asks(sessions[n]._session, chance.randint(1, n))  # type: ignore[misc]
            for n in counts
        }
        exact = in_turns(asking, queries)
        exact |= _after_recording(
            {n: sessions[n] for n in counts},
            lambda n, number: asks(sessions[n]._session, number),
            lambda: asks(bare, 1),
        )
        lists = in_turns(
            {
                "page": lambda: sessions[LISTED].database(limit=USUAL_PAGE),
                "list": sessions[LISTED].database,
            },
            OPENINGS,
        )
        lists |= _commands(listed)
        fresh = iter(range(max(counts) + 1, max(counts) + 100_000))
        recorded = in_turns(
            {
                f"record {n}": lambda n=n: sessions[n].record(recording(squat(next(fresh))))  # type: ignore[misc]
                for n in counts
            },
            RECORDINGS,
        )
        again = in_turns(
            {
                f"again {n}": lambda n=n: sessions[n].record(  # type: ignore[misc]
                    recording(squat(chance.randint(1, n)))
                )
                for n in counts
            },
            RECORDINGS,
        )
    opening = in_turns(
        {f"open {n}": lambda n=n: Database(paths[n]).close() for n in counts}, OPENINGS
    )  # type: ignore[misc]
    times = {**exact, **recorded, **again, **opening, **lists}
    return {
        "reply": size,
        "median": {name: median(each) for name, each in times.items()},
        "p10": {name: sorted(each)[len(each) // 10] for name, each in times.items()},
        "p99": {name: sorted(each)[int(0.99 * len(each))] for name, each in exact.items()},
    }


def _after_recording(
    sessions: dict[int, RemoteLearner], asks: Callable[[int, int], object], echo: Asking
) -> dict[str, list[float]]:
    """Time the first query for what was recorded just before, and an echo each time [s]."""
    times: dict[str, list[float]] = {f"after {n}": [] for n in sessions} | {"echo after": []}
    for number in range(1, RECORDINGS + 1):
        for n, learner in sessions.items():
            which = 1 + number % n
            learner.record(recording(squat(which)))
            before = perf_counter()
            asks(n, which)
            times[f"after {n}"].append(perf_counter() - before)
            before = perf_counter()
            echo()
            times["echo after"].append(perf_counter() - before)
    return times


def _commands(endpoint: str) -> dict[str, list[float]]:
    """Time the command that lists, and the start of any command of the network [s].

    Of both wall and CPU: the one is how long a user waits on this machine now, the other
    what there is to do.
    """
    of = ["--connect", endpoint]
    command = [sys.executable, "-m", "tsd_cli", "database", "list", *of]
    loading = "import tsd_cli.__main__, tsd_cli.command_line, tsd_cli.actions.entries"

    used: dict[str, list[float]] = {}

    def runs(name: str, line: list[str]) -> Asking:
        def run() -> None:
            before = os.times()
            subprocess.run(line, check=True, capture_output=True)
            after = os.times()
            spent = after.children_user + after.children_system
            spent -= before.children_user + before.children_system
            used.setdefault(f"{name} [CPU]", []).append(spent)

        return run

    lines = {
        "its start": [sys.executable, "-c", loading],
        "command": command,
        "command, all": [*command, "--limit", str(LISTED)],
    }
    times = in_turns({name: runs(name, line) for name, line in lines.items()}, OPENINGS)
    return times | used


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--entries", type=int, nargs="+", default=[10, 1_000, 100_000])
    parser.add_argument("--queries", type=int, default=1_000)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    counts = sorted(arguments.entries)
    with tempfile.TemporaryDirectory() as folder:
        found = measure(Path(folder), counts, arguments.queries)
    first = counts[0]
    print(f"replies of {found['reply']} bytes; [ms]   median   10 % are below")
    for name, each in found["median"].items():
        print(f"{name:30s} {1e3 * each:8.2f} {1e3 * found['p10'][name]:8.2f}")
    for count, kind in ((count, kind) for count in counts for kind in ("median", "p10")):
        times = found[kind]
        print(
            f"{count} entries, {kind}: exact {times[f'exact {count}'] / times['echo']:.2f} echoes, "
            f"{times[f'exact {count}'] / times[f'exact {first}']:.2f} times that of {first}; "
            f"just recorded {times[f'after {count}'] / times['echo after']:.2f}, any of all "
            f"{times[f'first {count}'] / times['echo']:.2f} echoes; "
            f"record {times[f'record {count}'] / times[f'record {first}']:.2f}, "
            f"again {times[f'again {count}'] / times[f'again {first}']:.2f} times"
        )
    if arguments.json:
        arguments.json.write_text(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
