from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.long
def test_logs_of_killed_runs_are_recovered() -> None:
    """A short form of the benchmark."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.killed_logs", "--times", "2", "--seed", "1"],
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert "2 of 2 read after recovery" in done.stdout
