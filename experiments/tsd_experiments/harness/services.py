"""Both services, started for an experiment and stopped after it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tsd_casadi.robot.robot import Robot
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_server.service_process import ServiceProcess, free_endpoint


@contextmanager
def start_services(robot: Robot) -> Iterator[tuple[RemoteController, RemoteLearner]]:
    """Start both services on free ports with a fresh database, to be stopped in any case.

    Yields:
        Clients of the two.
    """
    controller_endpoint, learner_endpoint = free_endpoint(), free_endpoint()
    with tempfile.TemporaryDirectory(prefix="tsd-services-") as folder:
        database = str(Path(folder) / "feedforward.sqlite")
        with (
            ServiceProcess(
                ["controller", "--robot", str(robot.path), "--listen", controller_endpoint]
            ),
            ServiceProcess(["learner", "--database", database, "--listen", learner_endpoint]),
            RemoteController(robot.name, [controller_endpoint]) as controller,
            RemoteLearner([learner_endpoint]) as learner,
        ):
            yield controller, learner
