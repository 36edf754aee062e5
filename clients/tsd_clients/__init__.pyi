from .learning import learn as learn
from .remote.remote_controller import RemoteController as RemoteController
from .remote.remote_learner import RemoteLearner as RemoteLearner
from .repetition import Gains as Gains
from .run import Run as Run
from .simulator.model_error import ModelError as ModelError
from .simulator.simulator import MujocoSimulator as MujocoSimulator
