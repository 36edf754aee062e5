"""Every error this project raises, in one hierarchy.

Each class carries its data as attributes; the message says what was wrong,
what was expected and what to do about it::

    TsdError
    ├── InvalidValue            (a ValueError) a number out of range
    ├── UnknownField            (a KeyError) a vector without that field
    ├── MalformedMessage        (a ValueError) bytes or JSON that cannot be read
    │   ├── UnsupportedVersion
    │   └── LayoutMismatch
    ├── SimulationError         a simulation that cannot be carried out
    ├── NotAvailable            what this computer does not have: an extra, a screen, a GL library
    ├── RobotError              the robot's files
    │   ├── RobotFileError
    │   ├── UnknownRobot
    │   └── ParityError
    ├── ControllerError         compiling, keeping and loading the controller
    │   ├── CompilerNotFound
    │   ├── CompilationFailed
    │   ├── CacheNotPrivate
    │   ├── CacheNotWritable
    │   └── NotLoadable
    ├── LogError                what a run wrote down
    │   ├── LogNotWritten
    │   └── LogNotWhole
    ├── LearningError           what was learned
    │   ├── DatabaseError
    │   ├── EntryNotFound
    │   ├── OutsideTrainedRange
    │   └── IncompatibleEntry
    └── ServiceError            between a service and its clients
        ├── ServiceUnreachable
        │   └── ServiceBusy
        ├── ServiceFailed
        ├── ServiceNotReady
        ├── ControllerSilent
        ├── EndpointTaken
        ├── AlreadyRunning
        ├── RunDirectoryUnusable
        ├── CertificateRefused
        └── TwoServices

An error that a service answers with arrives at the client as the class that the
library raises: ``except EntryNotFound`` holds for a local database and for a
remote learner alike, with its data as far as that is plain; ``str`` of it is the
service's message. A code without a class here arrives as ``ServiceFailed``.
"""

from tsd_casadi.exceptions.availability import NotAvailable
from tsd_casadi.exceptions.base import TsdError, class_of
from tsd_casadi.exceptions.controller import (
    CacheNotPrivate,
    CacheNotWritable,
    CompilationFailed,
    CompilerNotFound,
    ControllerError,
    NotLoadable,
)
from tsd_casadi.exceptions.learning import (
    DatabaseError,
    EntryNotFound,
    IncompatibleEntry,
    LearningError,
    OutsideTrainedRange,
)
from tsd_casadi.exceptions.logs import LogError, LogNotWhole, LogNotWritten
from tsd_casadi.exceptions.robot import ParityError, RobotError, RobotFileError, UnknownRobot
from tsd_casadi.exceptions.services import (
    AlreadyRunning,
    CertificateRefused,
    EndpointTaken,
    RunDirectoryUnusable,
    ServiceError,
    ServiceFailed,
    ServiceNotReady,
    TwoServices,
)
from tsd_casadi.exceptions.silence import ControllerSilent, ServiceBusy, ServiceUnreachable
from tsd_casadi.exceptions.simulation import SimulationError
from tsd_casadi.exceptions.values import (
    InvalidValue,
    LayoutMismatch,
    MalformedMessage,
    UnknownField,
    UnsupportedVersion,
)

__all__ = [
    "AlreadyRunning",
    "CacheNotPrivate",
    "CacheNotWritable",
    "CertificateRefused",
    "CompilationFailed",
    "CompilerNotFound",
    "ControllerError",
    "ControllerSilent",
    "DatabaseError",
    "EndpointTaken",
    "EntryNotFound",
    "IncompatibleEntry",
    "InvalidValue",
    "LayoutMismatch",
    "LearningError",
    "LogError",
    "LogNotWhole",
    "LogNotWritten",
    "MalformedMessage",
    "NotAvailable",
    "NotLoadable",
    "OutsideTrainedRange",
    "ParityError",
    "RobotError",
    "RobotFileError",
    "RunDirectoryUnusable",
    "ServiceBusy",
    "ServiceError",
    "ServiceFailed",
    "ServiceNotReady",
    "ServiceUnreachable",
    "SimulationError",
    "TsdError",
    "TwoServices",
    "UnknownField",
    "UnknownRobot",
    "UnsupportedVersion",
    "class_of",
]
