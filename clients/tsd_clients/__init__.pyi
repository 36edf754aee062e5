from .logs.log_file import save_log as save_log
from .remote.remote_controller import RemoteController as RemoteController
from .remote.remote_learner import RemoteLearner as RemoteLearner
from .simulator.model_error import ModelError as ModelError
from .simulator.simulator import MujocoSimulator as MujocoSimulator
