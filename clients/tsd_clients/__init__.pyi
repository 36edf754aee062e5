from .learning import learn as learn
from .model_error import ModelError as ModelError
from .remote_controller import RemoteController as RemoteController
from .remote_learner import RemoteLearner as RemoteLearner
from .repetition import Gains as Gains
from .run import Run as Run
from .simulator import MujocoSimulator as MujocoSimulator
