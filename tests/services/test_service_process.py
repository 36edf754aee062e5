import os
import select
import signal
import subprocess
import sys
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
        "import signal; import sys; from tsd_server.service_process import *;"
        "s = ServiceProcess(['learner', '--database', sys.argv[1], '--listen', free_endpoint()]);"
        "print(s.process.pid, flush=True); signal.pause()"
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", program, str(tmp_path / "a.sqlite")],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert parent.stdout is not None
    # of the service, which is no child of this process
    handle = os.pidfd_open(int(parent.stdout.readline()))
    parent.kill()
    parent.wait()
    parent.stdout.close()
    try:
        ended, _, _ = select.select([handle], [], [], 5.0)
        if not ended:
            signal.pidfd_send_signal(handle, signal.SIGKILL)
    finally:
        os.close(handle)
    assert ended
