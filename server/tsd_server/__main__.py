"""``python -m tsd_server controller|learner``: start a service."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tsd_casadi.exceptions import TsdError
from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a service until it is told to stop.

    Args:
        arguments: Role and options; the command line's by default.

    Returns:
        Exit code: 0 told to stop, 1 refused or failed.
    """
    parser = argparse.ArgumentParser(prog="python -m tsd_server", description=__doc__)
    roles = parser.add_subparsers(dest="role", required=True)
    for role, endpoint in (("controller", CONTROLLER), ("learner", LEARNER)):
        options = roles.add_parser(role)
        options.add_argument("--listen", action="append", metavar="ENDPOINT", help=endpoint)
    roles.choices["controller"].add_argument("--robot", default="hermes_lower")
    roles.choices["learner"].add_argument("--database", type=Path)
    given = parser.parse_args(arguments)
    try:
        if given.role == "controller":
            from tsd_casadi.robot.robot import load_robot
            from tsd_server.controller_service import ControllerService

            ControllerService(load_robot(given.robot), given.listen or [CONTROLLER]).run()
        else:
            from tsd_casadi.database.database import default_path
            from tsd_server.learner_service import LearnerService

            LearnerService(given.database or default_path(), given.listen or [LEARNER]).run()
    except TsdError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
