"""Clients of the services: simulator, remote controller, remote learner, command line."""

from tsd_clients.learning import learn
from tsd_clients.model_error import ModelError
from tsd_clients.remote_controller import RemoteController
from tsd_clients.remote_learner import RemoteLearner
from tsd_clients.repetition import Gains
from tsd_clients.run import Run
from tsd_clients.simulator import MujocoSimulator

__all__ = [
    "Gains",
    "ModelError",
    "MujocoSimulator",
    "RemoteController",
    "RemoteLearner",
    "Run",
    "learn",
]
