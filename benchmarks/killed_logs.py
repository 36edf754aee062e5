"""What is left of logs whose processes are killed while the robot moves.

Run: python -m benchmarks.killed_logs [--times N] [--seed N]

Each time a paced 'tsd simulate --log FILE.mcap' begins; at a random moment the process
that writes and the run itself get SIGKILL, one right after the other. The file is
recovered and read with every checksum: its ticks have to be one period apart from the
first on, and what was lost at its end has to be less than a chunk.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tsd_clients.logs.mcap_file import CHUNK_SIZE
from tsd_clients.logs.read_log import read_log
from tsd_clients.logs.recover_log import recover_log
from tsd_clients.logs.run_summary import KILLED

# after the robot began to move [s]; a lap takes one
EARLIEST, LATEST = 0.5, 6.0
PATIENCE = 120.0  # s, for a run to begin


def begin(path: Path) -> subprocess.Popen[bytes]:
    """Start a run that lasts longer than it may live."""
    options = ["--controller", "local", "--pace", "1", "--frequency", "1", "--laps", "30"]
    command = [sys.executable, "-m", "tsd_cli", "simulate", "squat", *options, "--log", str(path)]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def writer_of(run: subprocess.Popen[bytes], path: Path) -> int:
    """Wait until ticks are being written, and find the process that does."""
    deadline = time.monotonic() + PATIENCE
    children = Path(f"/proc/{run.pid}/task/{run.pid}/children")
    while time.monotonic() < deadline and run.poll() is None:
        if path.exists() and path.stat().st_size > 200_000:
            for child in children.read_text().split():
                if str(path) in Path(f"/proc/{child}/cmdline").read_text():
                    return int(child)
        time.sleep(0.05)
    raise SystemExit(f"the run did not begin within {PATIENCE:g} s")


def kill_one(path: Path, moment: float) -> tuple[int, int]:
    """Kill a run and its writer, and recover the log.

    Args:
        path: The file of the log.
        moment: When, after ticks are being written [s].

    Returns:
        Number of ticks, and of the bytes at the end of the file that are no whole chunk.
    """
    run = begin(path)
    try:
        writer = writer_of(run, path)
        time.sleep(moment)
        os.kill(writer, signal.SIGKILL)
    finally:
        run.kill()
        run.wait()
    size = path.stat().st_size
    copied = recover_log(path, path)
    assert not copied.is_whole and not copied.damaged
    log = read_log(path)
    assert log.summary == {"aborted": KILLED} and log.ticks == copied.ticks > 0
    times = log.fields["time"]
    assert np.allclose(times, 1e-3 * np.arange(log.ticks), rtol=0.0, atol=1e-9)
    # before compression, but for the names of fields
    assert size - copied.read < 1.1 * CHUNK_SIZE
    return log.ticks, size - copied.read


def main() -> None:
    """Kill and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    moments = random.Random(arguments.seed)
    lost = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(arguments.times):
            moment = moments.uniform(EARLIEST, LATEST)
            ticks, end = kill_one(Path(folder) / f"{number}.mcap", moment)
            lost.append(end)
            print(f"{number:3d}: {ticks} ticks recovered, {end} bytes at the end lost", flush=True)
    print(f"{len(lost)} of {arguments.times} read after recovery, {max(lost)} bytes lost at most")


if __name__ == "__main__":
    main()
