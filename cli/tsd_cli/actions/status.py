"""Which services run, and how they are."""

from __future__ import annotations

import json
from typing import Any

import typer

from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.services import ConnectOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.service_tables import print_services
from tsd_clients.remote.service_health import ServiceState, services_at, services_here

SILENT = 1


@interruptible()
def show_status(services: ConnectOptions, output: JsonOptions) -> None:
    """Show the services that run here, or those at the endpoints that are named.

    Raises:
        TsdError: If it cannot be found out.
        typer.Exit: If one does not answer.
    """
    check_outputs(output)
    if services.connect or services.zenoh_config is not None:
        file = services.zenoh_file()
        endpoints = services.connect or ([] if file is None else file.endpoints("connect"))
        found = [state for endpoint in endpoints for state in services_at(endpoint, file)]
    else:
        found = services_here()
    result = {"format": "tsd.status/1", "services": [_plain(state) for state in found]}
    put_out(result, output, lambda: print_services(found))
    if any(state.health is None for state in found):
        raise typer.Exit(SILENT)


def _plain(state: ServiceState) -> dict[str, Any]:
    return {
        "endpoints": list(state.endpoints),
        "trouble": state.trouble or None,
        "record": None if state.record is None else json.loads(state.record.encode()),
        "health": None if state.health is None else json.loads(state.health.encode()),
    }
