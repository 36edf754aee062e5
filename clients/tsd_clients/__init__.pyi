from tsd_clients.learning import learn as learn
from tsd_clients.model_error import ModelError as ModelError
from tsd_clients.remote_controller import RemoteController as RemoteController
from tsd_clients.remote_learner import RemoteLearner as RemoteLearner
from tsd_clients.repetition import Gains as Gains
from tsd_clients.run import Run as Run
from tsd_clients.simulator import MujocoSimulator as MujocoSimulator
