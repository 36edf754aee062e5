"""Somebody who watches a run of this machine, thirty times a second, until it is over.

Run: python -m benchmarks.watcher PID
"""

from __future__ import annotations

import sys
import time

from tsd_clients.telemetry.watched_run import WatchedRun, watched_runs


def main() -> None:
    """Say 'watching' once the run is seen, and in the end how many rows were."""
    pid, rows, is_seen = int(sys.argv[1]), 0, False
    while not (records := [record for record in watched_runs() if record.pid == pid]):
        time.sleep(0.03)
    with WatchedRun(records[-1]) as run:
        while not run.ended:
            rows += len(run.take())
            if run.outline is not None and not is_seen:
                is_seen = True
                print("watching", flush=True)
            time.sleep(0.033)
    print(rows, flush=True)


if __name__ == "__main__":
    main()
