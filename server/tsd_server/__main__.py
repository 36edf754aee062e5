"""``python -m tsd_server controller|learner``: start a service in this process."""

try:
    # before anything else: from here on Ctrl-C prints no traceback
    from tsd_server.end_at_once import end_at_once

    end_at_once()
    # before numpy
    from tsd_casadi.single_thread import use_single_thread

    use_single_thread()
except KeyboardInterrupt:
    raise SystemExit(130) from None

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tsd_casadi.exceptions import TsdError
from tsd_casadi.version import __version__
from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER
from tsd_server.log_level import LEVELS, show_log
from tsd_server.serve import end_process, serve_controller, serve_learner

OVERVIEW = """\
Start one of the two services in this process; 'tsd controller' and 'tsd learner'
do the same.

A service says 'ready on ENDPOINT' on stdout once it answers, and ends on Ctrl-C
or SIGTERM within two seconds."""
EXAMPLES = """\
examples:
  python -m tsd_server controller
  python -m tsd_server controller --robot my_robot.yaml --listen tcp/127.0.0.1:7450
  python -m tsd_server learner --database runs/feedforward.sqlite

exit codes: 0 told to stop while serving, 1 refused or failed (the reason is on
stderr), 2 wrong usage; a signal before the service is ready ends the process
by itself (130 and 143 in a shell)

environment: TSD_CACHE_DIR, the folder of compiled controllers; TSD_RUN_DIR, the folder
in which services say that they run; CC, the C compiler"""
CONTROLLER_HELP = """\
Answer state and command with torques, at every tick, for one robot.

The first start compiles the robot's controller, which takes about 20 s and is
told on stderr; it is kept in a cache."""
LEARNER_HELP = """\
Keep what was learned and answer with feedforward terms, for every robot."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a service until it is told to stop; then the process has ended.

    Args:
        arguments: Role and options; those of the process by default.

    Returns:
        Exit code 1, if the service was refused or failed.
    """
    given = _parser().parse_args(arguments)
    show_log(given.log_level)
    try:
        from tsd_server.place import Place

        place = Place(given.listen or (), given.zenoh_config, given.expose)
        if given.role == "controller":
            serve_controller(given.robot, place)
        serve_learner(given.database, place)
    except TsdError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(
        prog="python -m tsd_server", description=OVERVIEW, epilog=EXAMPLES, formatter_class=raw
    )
    parser.add_argument("--version", action="version", version=f"tsd_casadi {__version__}")
    roles = parser.add_subparsers(dest="role", required=True, metavar="controller|learner")
    for role, summary, text, endpoint in (
        ("controller", "state and command in, torques out", CONTROLLER_HELP, CONTROLLER),
        ("learner", "keeps and answers what was learned", LEARNER_HELP, LEARNER),
    ):
        options = roles.add_parser(role, help=summary, description=text, formatter_class=raw)
        options.add_argument(
            "--listen",
            action="append",
            metavar="ENDPOINT",
            help=f"where to listen, may be given several times (default: {endpoint})",
        )
        options.add_argument(
            "--zenoh-config",
            type=Path,
            metavar="FILE",
            help="a Zenoh configuration: certificates, user names, routers",
        )
        options.add_argument(
            "--expose",
            action="store_true",
            help="let other machines in that reach the endpoint, without any such file",
        )
        level = options.add_mutually_exclusive_group()
        level.add_argument(
            "--log-level", choices=LEVELS, help="what to tell on stderr (default: warning)"
        )
        level.add_argument(
            "--verbose",
            action="store_const",
            const="info",
            dest="log_level",
            help="the same as --log-level info",
        )
        if role == "controller":
            options.add_argument(
                "--robot",
                default="hermes_lower",
                metavar="NAME|FILE",
                help="name of a shipped robot or path of a robot file (default: %(default)s)",
            )
        else:
            options.add_argument(
                "--database",
                type=Path,
                metavar="FILE",
                help="SQLite file, made if there is none (default: in the user's data folder)",
            )
    return parser


if __name__ == "__main__":
    end_process(main())
