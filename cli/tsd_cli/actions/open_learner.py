"""The learner that options stand for, for commands that load no robot."""

from __future__ import annotations

from tsd_casadi.wire.endpoints import LEARNER
from tsd_cli.options.services import ConnectOptions
from tsd_clients.remote.remote_learner import RemoteLearner


def open_learner(options: ConnectOptions) -> RemoteLearner:
    """Connect to the learner of the options.

    Raises:
        ServiceUnreachable: If no service answers.
    """
    return RemoteLearner(options.endpoints(LEARNER), zenoh_file=options.zenoh_file())
