"""'tsd robot': the robots there are."""

from __future__ import annotations

from tsd_cli.option_groups import with_groups
from tsd_cli.options.output import JsonOptions


@with_groups
def list_robots(output: JsonOptions) -> None:
    """List the robots that come with the project.

    Each name is one for --robot; a robot of your own is the path of its file.

      tsd robot list
      tsd robot list --json -
    """
    from tsd_cli.actions.robots import show_robots

    show_robots(output)
