"""How long it takes until something can be asked: imports, help, the first correct tick.

    python -m benchmarks.startup [--runs N] [--json FILE]

Each command is started anew, all of them in turn, N times; the medians are
compared with ``python -c "import numpy"`` of the same run. The controller has to
be compiled already: a first run does that.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

FIRST_TICK = (
    "import tsd_casadi as tsd; robot = tsd.load_robot('hermes_lower'); "
    "controller = tsd.compile_controller(robot); "
    "tick = controller.tick(robot.home, controller.command()); assert tick.status == 0"
)
COMMANDS = {
    "import numpy": [sys.executable, "-c", "import numpy"],
    "import tsd_casadi": [sys.executable, "-c", "import tsd_casadi"],
    "tsd --help": [sys.executable, "-m", "tsd_cli", "--help"],
    "first correct tick": [sys.executable, "-c", FIRST_TICK],
}
# wall or CPU time, and the most it may be [s]
GOALS = {
    "import tsd_casadi": ("cpu", 0.35),
    "tsd --help": ("wall", 0.5),
    "first correct tick": ("wall", 0.7),
}


def measure(command: list[str]) -> tuple[float, float]:
    """Run a command.

    Returns:
        Wall and CPU time of the whole process [s].
    """
    before, start = os.times(), time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - start, os.times()
    cpu = after.children_user + after.children_system
    return wall, cpu - before.children_user - before.children_system


def main() -> int:
    """Print the table.

    Returns:
        0 if every goal is met, else 1.
    """
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=11, metavar="N", help="of each, default 11")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the medians there too")
    given = parser.parse_args()
    for command in COMMANDS.values():
        measure(command)  # warm: compiled files, the controller
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in COMMANDS}
    for _ in range(given.runs):
        for name, command in COMMANDS.items():
            times[name].append(measure(command))
    rows = {
        name: {
            kind: statistics.median(pair[place] for pair in pairs)
            for place, kind in enumerate(("wall", "cpu"))
        }
        for name, pairs in times.items()
    }
    print(f"medians of {given.runs} runs [s]\n\n  {'':20} {'wall':>7} {'CPU':>7}   goal")
    missed = 0
    for name, row in rows.items():
        goal = ""
        if name in GOALS:
            kind, most = GOALS[name]
            met = row[kind] <= most
            missed += not met
            goal = f"{kind} <= {most:g}, {'met' if met else 'missed'}"
        print(f"  {name:20} {row['wall']:7.3f} {row['cpu']:7.3f}   {goal}")
    if given.json is not None:
        given.json.write_text(json.dumps(rows, indent=2))
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
