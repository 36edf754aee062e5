"""Clients that do not read and connections that say nothing do not stop the others."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import tsd_casadi as tsd

ROOT = Path(__file__).parents[2]


@pytest.mark.timeout(200)
def test_a_running_client_is_answered_beside_a_crowd(controller: tsd.Controller) -> None:
    """Bounded: no time is asserted but that every tick is answered in half a second."""
    options = ["--deaf", "5", "--frozen", "5", "--silent", "300", "--rounds", "1", "--seconds", "6"]
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.crowd", *options, "--count-only"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
