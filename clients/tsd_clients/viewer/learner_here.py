"""The learner that runs here, wherever it listens."""

from __future__ import annotations

from tsd_casadi.exceptions import ServiceUnreachable
from tsd_casadi.wire.endpoints import LEARNER
from tsd_casadi.wire.run_directory import running
from tsd_clients.remote.remote_learner import RemoteLearner


def open_learner_here() -> RemoteLearner:
    """Connect to the learner of the run directory, that which was started last if there are more.

    Raises:
        ServiceUnreachable: If none runs, or it does not answer.
        RunDirectoryUnusable: If the run directory is not one.
    """
    found = [record for record in running() if record.role == "learner"]
    if not found:
        raise ServiceUnreachable("learner", [LEARNER], "none runs here; 'tsd learner' starts one")
    newest = max(found, key=lambda record: record.started)
    return RemoteLearner(newest.endpoints[:1])
