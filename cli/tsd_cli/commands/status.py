"""'tsd status': which services run, and how they are."""

from __future__ import annotations

from tsd_cli.option_groups import with_groups
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.services import ConnectOptions


@with_groups
def status(services: ConnectOptions, output: JsonOptions) -> None:
    """Say which services run here and how they are.

    For which robot, at which endpoint, since when; what they answered, refused and
    failed at, and how fast. Exit code 1 if one does not answer.

      tsd status
      tsd status --json -
      tsd status --connect tls/robot.local:7447 --zenoh-config me.json5
    """
    from tsd_cli.actions.status import show_status

    show_status(services, output)
