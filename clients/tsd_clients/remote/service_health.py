"""How services are: those that run here, and others that are named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tsd_casadi.exceptions import ServiceUnreachable, TsdError
from tsd_casadi.wire.health import HealthMessage
from tsd_casadi.wire.keys import health_key
from tsd_casadi.wire.run_directory import is_stopped, running
from tsd_casadi.wire.run_record import RunRecord
from tsd_casadi.wire.zenoh_file import ZenohFile
from tsd_clients.remote.session import Session
from tsd_clients.remote.silence import ANY, explain_silence

# for a link, and for the answer; a service that is well takes some milliseconds [s]
PATIENCE = 1.0
ROLES = ("controller", "learner")
NO_ANSWER = "starting, or frozen"


@dataclass(frozen=True)
class ServiceState:
    """One service, and how it is.

    Attributes:
        endpoints: Where it listens.
        record: What it says of itself in the run directory, if it runs here.
        health: What it answered, if it did.
        trouble: Why it did not.
    """

    endpoints: Sequence[str]
    record: RunRecord | None = None
    health: HealthMessage | None = None
    trouble: str = ""


def services_here() -> list[ServiceState]:
    """Ask all services of the run directory how they are.

    Raises:
        RunDirectoryUnusable: If there is no such folder of the user's.
    """
    return [_state_of(record) for record in running() if record.role in ROLES]


def services_at(endpoint: str, zenoh_file: ZenohFile | None = None) -> list[ServiceState]:
    """Ask the services at an endpoint how they are: one, or those behind a router."""
    try:
        session = Session(ANY, [endpoint], zenoh_file=zenoh_file)
        try:
            session.wait_for("*", PATIENCE)
            return [
                ServiceState([endpoint], health=ask_health(session, robot, role))
                for robot, role in sorted(session.alive())
            ]
        finally:
            session.close()
    except ServiceUnreachable:
        return [ServiceState([endpoint], trouble=explain_silence(ANY, [endpoint]))]
    except TsdError as error:
        return [ServiceState([endpoint], trouble=str(error))]


def _state_of(record: RunRecord) -> ServiceState:
    if trouble := why_not_asked(record):
        return ServiceState(record.endpoints, record, trouble=trouble)
    try:
        session = Session(record.role, record.endpoints[:1])
        try:
            session.wait_for(record.robot, PATIENCE)
            health = ask_health(session, record.robot, record.role)
        finally:
            session.close()
    except TsdError:
        return ServiceState(record.endpoints, record, trouble=NO_ANSWER)
    return ServiceState(record.endpoints, record, health)


def why_not_asked(record: RunRecord) -> str:
    """Say why a service that runs here cannot be asked how it is; empty if it can be."""
    if is_stopped(record.pid):
        return f"frozen: process {record.pid} is stopped, 'kill -CONT {record.pid}' lets it go on"
    if not any(endpoint.startswith(("tcp/", "unixsock")) for endpoint in record.endpoints):
        # only the user has the certificate for it
        return "not asked: name it with --connect and its --zenoh-config"
    return ""


def ask_health(session: Session, robot: str, role: str) -> HealthMessage:
    """Ask a service how it is, over a session with it.

    Raises:
        TsdError: If it does not answer, or with something else.
    """
    (body,) = session.query(health_key(robot, role), timeout=PATIENCE)[:1]
    return HealthMessage.decode(body)
