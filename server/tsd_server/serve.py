"""A service as this whole process: from its first line to its exit code."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from tsd_server.end_at_once import end_at_once

if TYPE_CHECKING:
    from tsd_server.place import Place


def serve_controller(robot: str, place: Place | None = None) -> NoReturn:
    """Serve a robot's controller until SIGINT or SIGTERM, then end the process with 0.

    Args:
        robot: Name of a shipped robot, or path of a robot file.
        place: Where to listen; the usual one by default.

    Raises:
        TsdError: If the robot, the endpoint or the compiler cannot be used.
    """
    end_at_once()
    from tsd_casadi.robot.robot import load_robot
    from tsd_server.controller_service import ControllerService
    from tsd_server.place import Place

    ControllerService(load_robot(robot), place or Place()).run()
    end_process(0)


def serve_learner(database: Path | None = None, place: Place | None = None) -> NoReturn:
    """Serve the learner until SIGINT or SIGTERM, then end the process with 0.

    Args:
        database: SQLite file, made if there is none; by default in the user's
            data folder.
        place: Where to listen; the usual one by default.

    Raises:
        TsdError: If the database or the endpoint cannot be used.
    """
    end_at_once()
    from tsd_casadi.database.database import default_path
    from tsd_server.learner_service import LearnerService
    from tsd_server.place import Place

    LearnerService(database or default_path(), place or Place()).run()
    end_process(0)


def end_process(code: int) -> NoReturn:
    """End this process without taking the interpreter apart.

    All that had to be closed is closed by now. Threads of Zenoh that do not end
    would keep the interpreter from ending, and static objects in C++ that go before
    the threads that use them would crash it.

    Args:
        code: Exit code.
    """
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # closed, or not there
            stream.flush()
    os._exit(code)
