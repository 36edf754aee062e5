"""Why a service says nothing, as far as it can be told from outside."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from socket import create_connection

from tsd_casadi.exceptions import RunDirectoryUnusable, ServiceBusy, ServiceUnreachable
from tsd_casadi.wire.endpoints import is_of_this_machine
from tsd_casadi.wire.run_directory import is_stopped, running
from tsd_casadi.wire.run_record import RunRecord

# for a connection; a machine that answers at all does so sooner [s]
CONNECTING = 1.0
# for the role of whoever asks all of them
ANY = "*"


def explain_silence(role: str, endpoints: Sequence[str]) -> str:
    """Tell a service that is missing from one that is frozen, for each endpoint.

    Args:
        role: Of the service that is missed; ``ANY`` for whichever is there.
        endpoints: Where nobody answered.
    """
    return "; ".join(_explain(role, endpoint) for endpoint in endpoints)


def silence_of(
    role: str, endpoints: Sequence[str], words: str, waited: float | None
) -> ServiceUnreachable:
    """Make the error for a service that did not answer a question.

    Args:
        endpoints: Where it was looked for.
        words: What is known of the silence.
        waited: For how long it was waited for it, if it is there [s]; None if it is not.
    """
    records = [_record_at(endpoint) for endpoint in endpoints]
    is_frozen = any(
        record is not None and role in (ANY, record.role) and is_stopped(record.pid)
        for record in records
    )
    if waited is None or is_frozen:
        return ServiceUnreachable(role, endpoints, f"{words}; {explain_silence(role, endpoints)}")
    return ServiceBusy(role, endpoints, waited)


def _explain(role: str, endpoint: str) -> str:
    record = _record_at(endpoint)
    if record is not None and role not in (ANY, record.role):
        # one of two endpoints of ours, say: how that service is explains nothing
        return f"at {endpoint} is the {record.role}, process {record.pid}"
    if record is not None and is_stopped(record.pid):
        return (
            f"the {record.role} at {endpoint} is frozen: process {record.pid} is stopped, "
            f"'kill -CONT {record.pid}' lets it go on"
        )
    protocol, _, address = endpoint.partition("/")
    if protocol not in ("tcp", "tls"):
        return f"{endpoint} is silent"
    host, _, port = address.rpartition(":")
    try:
        create_connection((host.strip("[]"), int(port)), timeout=CONNECTING).close()
    except ConnectionRefusedError:
        return f"nothing listens at {endpoint}"
    except OSError as error:
        return f"{endpoint} cannot be reached: {error.strerror or error}"
    if record is not None:
        return f"the {record.role} at {endpoint}, process {record.pid}, is starting or frozen"
    return (
        f"{endpoint} takes connections but says nothing: a service that is starting or frozen, "
        "one that asks for a certificate, or another program"
    )


def _record_at(endpoint: str) -> RunRecord | None:
    if not is_of_this_machine(endpoint):
        return None
    port = endpoint.rpartition(":")[2]
    with suppress(RunDirectoryUnusable, OSError):
        for record in running():
            for each in record.endpoints:
                if each == endpoint or each.rpartition(":")[2] == port:
                    return record
    return None
