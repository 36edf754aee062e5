"""Whether a service ends at its first signal, whatever it is doing.

Run: python -m benchmarks.signals [--cycles N] [--load N] [--compiling SHARE] [--json FILE]

In every cycle a service is started and gets one SIGINT or SIGTERM at a random
moment: while it starts, builds the problem, compiles, serves a client that keeps
asking. '--load 2' keeps two more processes per core busy meanwhile. A signal is
lost if the process is still there after 10 s, slow if it took more than 2 s.
Exit code 1 if one was, if a traceback of ours or a compiler or a temporary file
was left. Ctrl-C shows what is known by then.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.stopped_service import Stop, start_and_stop, time_to_ready
from tsd_casadi.compilation.code_cache import cache_folder
from tsd_clients.console.progress import show_progress
from tsd_clients.console.table import Column, console, print_table

ALLOWED = 2.0  # s
# share of learners among the services that do not compile
LEARNERS = 0.15
# signals come until this share of the time to get ready, so some find it serving
BEYOND = 1.4
BUSY = "import os; parent = {}\nwhile os.getppid() == parent: sum(range(100_000))"


@contextmanager
def busy_processes(count: int) -> Iterator[None]:
    """Keep processes busy, which end with this one at the latest.

    Args:
        count: How many.
    """
    command = [sys.executable, "-c", BUSY.format(os.getpid())]
    processes = [subprocess.Popen(command) for _ in range(count)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def stop_services(cycles: int, compiling: float, seed: int) -> Iterator[Stop]:
    """Start and stop services at random moments.

    Args:
        cycles: How many.
        compiling: Share of them that find an empty cache.
        seed: Of roles, signals and moments.
    """
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="tsd-signals-cache-") as folder:
        # a cache of its own: what others compile meanwhile is not left behind by these services
        cached = Path(folder) / "compiled"
        if not compiling:
            shutil.copytree(cache_folder(), cached, ignore=shutil.ignore_patterns("build-*"))
        # the first compiles, if the user's cache did not have it: no measure for those after it
        taken = time_to_ready("controller", cached)
        ready = {role: time_to_ready(role, cached) for role in ("controller", "learner")}
        for cycle in range(cycles):
            number = rng.choice((signal.SIGINT, signal.SIGTERM))
            if rng.random() < compiling:
                cache, role = Path(folder) / f"empty-{cycle}", "controller"
                delay = rng.uniform(0.0, taken)
            else:
                cache, role = cached, "learner" if rng.random() < LEARNERS else "controller"
                delay = rng.uniform(0.0, BEYOND * ready[role])
            yield start_and_stop(role, cache, number, delay)


def summarize(stops: Sequence[Stop]) -> dict[str, Any]:
    """Count what went wrong.

    Args:
        stops: Any number of cycles.
    """
    durations = [stop.duration for stop in stops if stop.duration is not None]
    return {
        "cycles": len(stops),
        "lost": len(stops) - len(durations),
        "slow": sum(duration > ALLOWED for duration in durations),
        "tracebacks": sum(stop.traceback == "ours" for stop in stops),
        "tracebacks_before_our_first_line": sum(stop.traceback == "python" for stop in stops),
        "orphans": sum(stop.orphans for stop in stops),
        "left_behind": sum(len(stop.left_behind) for stop in stops),
        "median": statistics.median(durations) if durations else None,
        "longest": max(durations, default=None),
        "exit_codes": dict(sorted(Counter(stop.exit_code for stop in stops).items())),
    }


def print_summaries(summaries: dict[str, dict[str, Any]], title: str) -> None:
    """Print one row for each phase and one for all."""

    def column(heading: str, name: str, rank: int = 0) -> Column:
        return Column(heading, [str(row[name]) for row in summaries.values()], rank)

    def seconds(heading: str, name: str) -> Column:
        values = [row[name] for row in summaries.values()]
        return Column(heading, ["-" if value is None else f"{value:.2f}" for value in values])

    codes = [
        " ".join(f"{code}:{count}" for code, count in row["exit_codes"].items())
        for row in summaries.values()
    ]
    print_table(
        title,
        [
            Column("when", list(summaries), is_text=True),
            column("cycles", "cycles"),
            column("lost", "lost"),
            column("slow", "slow"),
            column("trace\nbacks", "tracebacks"),
            column("before\nus", "tracebacks_before_our_first_line", 1),
            column("or\nphans", "orphans"),
            column("files\nleft", "left_behind"),
            seconds("median\n[s]", "median"),
            seconds("longest\n[s]", "longest"),
            Column("exit codes", codes, 2, is_text=True),
        ],
    )


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--cycles", type=int, default=500, help="services to start and stop")
    parser.add_argument("--load", type=int, default=2, help="busy processes per core")
    parser.add_argument("--compiling", type=float, default=0.08, help="share with an empty cache")
    parser.add_argument("--seed", type=int, default=0, help="of roles, signals and moments")
    parser.add_argument("--json", type=Path, help="write every cycle and the counts to this file")
    arguments = parser.parse_args()
    # a shell has it ignored in the background, and so would the services until their first line
    signal.signal(signal.SIGINT, signal.default_int_handler)
    busy = arguments.load * len(os.sched_getaffinity(0))
    stops: list[Stop] = []
    try:
        with busy_processes(busy), show_progress("stopping", arguments.cycles) as report:
            for stop in stop_services(arguments.cycles, arguments.compiling, arguments.seed):
                stops.append(stop)
                report(len(stops), arguments.cycles)
    except KeyboardInterrupt:
        console.print(f"interrupted after {len(stops)} of {arguments.cycles} cycles")
    phases = ("starting", "compiling", "serving")
    summaries = {
        phase: summarize([stop for stop in stops if stop.phase == phase]) for phase in phases
    }
    summaries["all"] = summarize(stops)
    print_summaries(summaries, f"first signals with {busy} busy processes")
    if arguments.json:
        cycles = [asdict(stop) for stop in stops]
        arguments.json.write_text(json.dumps({"summary": summaries, "cycles": cycles}, indent=2))
    wrong = ("lost", "slow", "tracebacks", "orphans", "left_behind")
    return int(any(summaries["all"][name] for name in wrong))


if __name__ == "__main__":
    sys.exit(main())
