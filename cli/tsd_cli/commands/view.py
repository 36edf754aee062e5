"""'tsd view': the live page."""

from __future__ import annotations

from tsd_cli.option_groups import with_groups
from tsd_cli.options.page import PageOptions, ReplayOptions


@with_groups
def view(page: PageOptions, replay: ReplayOptions) -> None:
    """Show robots, charts and services in a browser, live.

    The page finds services and runs of this machine by itself, those that start later, too.

      tsd view --open
      tsd simulate squat --laps 20 --pace 1

    A log, with a slider for its time; docs/view.md says where to click:

      tsd simulate squat --log run.npz
      tsd view --log run.npz
    """
    from tsd_cli.actions.view import show_page

    show_page(page, replay)
