"""What the live page costs its machine, and how soon it can be used.

Run: python -m benchmarks.page [--robot ROBOT] [--seconds N]

CPU time of the process of 'tsd view', without its browser: with nobody looking, with a
browser and no run, with a browser and a run of the robot; and the times from the command
to its address, from there to the page, and from there to a robot that is drawn.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

from benchmarks.chromium import address_of, chromium, command

PATIENCE = 120_000  # ms


def cpu_time(pid: int) -> float:
    """Read how long a process has computed [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def print_share(what: str, pid: int, seconds: float) -> None:
    """Print the share of a core that a process takes."""
    before, begun = cpu_time(pid), time.perf_counter()
    time.sleep(seconds)
    share = (cpu_time(pid) - before) / (time.perf_counter() - begun)
    print(f"{what}: {100 * share:.1f} % of a core", flush=True)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="g1")
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    run = ("simulate", "squat", "--robot", options.robot, "--controller", "local")
    with tempfile.TemporaryDirectory() as kept:
        folder, begun = Path(kept) / "run", time.perf_counter()
        with command(folder, "view") as view:
            address = address_of(view)
            print(f"from command to address: {time.perf_counter() - begun:.1f} s", flush=True)
            print_share("nobody looks", view.pid, options.seconds)
            with chromium() as browser:
                page = browser.new_page(viewport={"width": 1280, "height": 800})
                page.set_default_timeout(PATIENCE)
                begun = time.perf_counter()
                page.goto(address)
                page.get_by_role("tab", name="View", exact=True).click()
                print(f"from address to tabs: {time.perf_counter() - begun:.1f} s", flush=True)
                print_share("a browser, no run", view.pid, options.seconds)
                begun = time.perf_counter()
                with command(folder, *run, "--laps", "999"):
                    page.locator(f"[data-drawn~='{options.robot}']").wait_for(state="attached")
                    took = time.perf_counter() - begun
                    print(f"from 'tsd simulate' to its robot: {took:.1f} s", flush=True)
                    print_share("a browser and a run", view.pid, options.seconds)


if __name__ == "__main__":
    main()
