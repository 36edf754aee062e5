import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tsd_casadi.exceptions import ServiceNotReady
from tsd_server.service_process import ServiceProcess, free_endpoint


def test_what_the_process_printed_is_in_the_error() -> None:
    with pytest.raises(ServiceNotReady, match="no robot 'nobody'"):
        ServiceProcess(["controller", "--robot", "nobody", "--listen", free_endpoint()])


@pytest.mark.skipif(sys.platform != "linux", reason="the kernel's help exists on Linux only")
def test_service_ends_when_its_parent_is_killed(tmp_path: Path) -> None:
    program = (
        "import sys, time; from tsd_server.service_process import *;"
        "s = ServiceProcess(['learner', '--database', sys.argv[1], '--listen', free_endpoint()]);"
        "print(s.process.pid, flush=True); time.sleep(60)"
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", program, str(tmp_path / "a.sqlite")],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert parent.stdout is not None
    child = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    parent.stdout.close()
    deadline = time.monotonic() + 5.0
    while time.monotonic() < deadline and _is_running(child):
        time.sleep(0.05)
    alive = _is_running(child)
    if alive:
        os.kill(child, signal.SIGKILL)
    assert not alive


def _is_running(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False
