from .controller_service import ControllerService as ControllerService
from .learner_service import LearnerService as LearnerService
from .service_process import ServiceProcess as ServiceProcess
