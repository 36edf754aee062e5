"""Which services and runs there are, and how the services are."""

from __future__ import annotations

import json
from typing import Any

import typer

from tsd_casadi.wire.run_record import RunRecord
from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.services import ConnectOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.service_tables import print_runs_here, print_services
from tsd_clients.remote.service_health import ServiceState, services_at, services_here
from tsd_clients.telemetry.watched_run import watched_runs

SILENT = 1


@interruptible()
def show_status(services: ConnectOptions, output: JsonOptions) -> None:
    """Show the services and runs that are here, or the services at the endpoints that are named.

    Raises:
        TsdError: If it cannot be found out.
        typer.Exit: If one does not answer.
    """
    check_outputs(output)
    runs: list[RunRecord] = []
    if services.connect or services.zenoh_config is not None:
        file = services.zenoh_file()
        endpoints = services.connect or ([] if file is None else file.endpoints("connect"))
        found = [state for endpoint in endpoints for state in services_at(endpoint, file)]
    else:
        found, runs = services_here(), watched_runs()
    result = {
        "format": "tsd.status/1",
        "services": [_plain(state) for state in found],
        "runs": [json.loads(run.encode()) for run in runs],
    }

    def show() -> None:
        print_services(found)
        print_runs_here(runs)

    put_out(result, output, show)
    if any(state.health is None for state in found):
        raise typer.Exit(SILENT)


def _plain(state: ServiceState) -> dict[str, Any]:
    return {
        "endpoints": list(state.endpoints),
        "trouble": state.trouble or None,
        "record": None if state.record is None else json.loads(state.record.encode()),
        "health": None if state.health is None else json.loads(state.health.encode()),
    }
