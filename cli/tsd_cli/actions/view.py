"""The live page, for the command line."""

from __future__ import annotations

import ipaddress
import sys
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import load_robot
from tsd_cli.interrupt import interruptible
from tsd_cli.options.page import PageOptions, ReplayOptions
from tsd_cli.options.robot import RobotOptions
from tsd_clients.extra import require_extra
from tsd_clients.logs.log import Log
from tsd_clients.logs.read_log import read_log

if TYPE_CHECKING:
    from tsd_casadi.wire.telemetry import IterationRecorded
    from tsd_clients.viewer.page import Page
    from tsd_clients.viewer.page_server import PageServer


def show_page(options: PageOptions, replay: ReplayOptions) -> None:
    """Serve the page until Ctrl-C.

    Raises:
        TsdError: If it cannot be served, or the log cannot be used.
    """
    require_extra("view", "the live page", "viser", "fast_simplification")
    _serve(options, replay)


@interruptible()
def _serve(options: PageOptions, replay: ReplayOptions) -> None:
    from tsd_clients.viewer.page_server import open_server

    if options.allow_run and not _is_loopback(options.listen_on):
        raise InvalidValue(
            "--allow-run",
            f"with --host {options.listen_on}",
            "a page that only this machine reaches: without a password anybody could run things "
            "as you",
        )
    server = open_server(options.listen_on, options.port)
    page = _live(server, options.allow_run) if replay.log is None else _replayed(server, replay)
    port = server.get_port()
    if port != options.port:
        typer.echo(f"note: port {options.port} is taken", err=True)
    if not _is_loopback(options.listen_on):
        typer.echo(
            f"WARNING: everybody who reaches {options.listen_on} sees this page and its robots, "
            "without a password",
            err=True,
        )
    address = f"http://{options.listen_on}:{port}"
    typer.echo(f"page at {address}, Ctrl-C ends it")
    if options.browse:
        webbrowser.open(address)
    page.run()


def _live(server: PageServer, allow_run: bool) -> Page:
    import tsd_models
    from tsd_clients.viewer.learner_here import open_learner_here
    from tsd_clients.viewer.learner_link import LearnerLink
    from tsd_clients.viewer.live_runs import LiveRuns
    from tsd_clients.viewer.page import Page
    from tsd_clients.viewer.panels.explorer_panel import ExplorerPanel
    from tsd_clients.viewer.panels.joint_panel import JointPanel
    from tsd_clients.viewer.panels.learning_panel import LearningPanel
    from tsd_clients.viewer.panels.motion_panel import MotionPanel
    from tsd_clients.viewer.panels.robot_panel import RobotPanel
    from tsd_clients.viewer.panels.run_panel import RunPanel
    from tsd_clients.viewer.panels.service_panel import ServicePanel
    from tsd_clients.viewer.run_buttons import RunButtons
    from tsd_clients.viewer.service_watch import ServiceWatch

    runs, watch, link = LiveRuns(), ServiceWatch(), LearnerLink(open_learner_here)

    def robots() -> dict[str, str]:
        # a shipped robot goes by its name, one that runs by the file that it runs with
        shipped = {name: name for name in tsd_models.robot_files()}
        return {run.label.robot: run.label.robot_file for run in runs.live} | shipped

    def iterations() -> list[IterationRecorded]:
        return [each for run in runs.live for each in run.watched.iterations]

    buttons = RunButtons([sys.executable, "-m", "tsd_cli"], robots) if allow_run else None
    chosen = RunPanel(runs)
    panels = (
        chosen,
        MotionPanel(chosen),
        JointPanel(chosen),
        LearningPanel(link, iterations),
        ExplorerPanel(link, buttons),
        ServicePanel(watch),
        RobotPanel(runs),
    )
    feeds = (runs, watch, link) if buttons is None else (runs, watch, link, buttons)
    return Page(server, feeds, panels)


def _replayed(server: PageServer, options: ReplayOptions) -> Page:
    from tsd_clients.viewer.page import Page
    from tsd_clients.viewer.panels.joint_panel import JointPanel
    from tsd_clients.viewer.panels.motion_panel import MotionPanel
    from tsd_clients.viewer.panels.replay_panel import ReplayPanel
    from tsd_clients.viewer.panels.robot_panel import RobotPanel
    from tsd_clients.viewer.panels.run_panel import RunPanel
    from tsd_clients.viewer.replay import Replay

    assert options.log is not None
    log = read_log(options.log)
    robot = load_robot(options.robot or _robot_of(log))
    replay = Replay(options.log, log, robot)
    chosen = RunPanel(replay)
    panels = (
        ReplayPanel(replay),
        chosen,
        MotionPanel(chosen),
        JointPanel(chosen),
        RobotPanel(replay),
    )
    return Page(server, (replay,), panels)


def _robot_of(log: Log) -> str:
    """Find the robot of a log: its file, if it is where it was."""
    if log.outline is not None and Path(log.outline.robot_file).is_file():
        return log.outline.robot_file
    return log.robot or RobotOptions().robot


def _is_loopback(address: str) -> bool:
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return address == "localhost"
