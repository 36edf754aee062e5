"""A service is missing, is one too many or has failed."""

from __future__ import annotations

from pathlib import Path

from tsd_casadi.exceptions.base import TsdError


class ServiceError(TsdError):
    """What is wrong between a service and its clients.

    What a service refuses is not one of these: it arrives as the class that
    the library raises in the same case, ``EntryNotFound`` for instance.
    """


class ServiceFailed(ServiceError):
    """A service answered with an error that has no class here.

    Its own defect, code 'internal', or an error of another version of this
    software.

    Attributes:
        code: The service's error code.
    """

    def __init__(self, code: str, message: str) -> None:
        """Create the error from a reply's fields."""
        self.code = code
        super().__init__(message)


class ServiceNotReady(ServiceError):
    """A service that was started did not get ready."""

    code = "not_ready"


class EndpointTaken(ServiceError):
    """Another process listens on the endpoint already.

    Attributes:
        endpoint: The endpoint.
    """

    code = "endpoint_taken"
    endpoint: str | None = None

    def __init__(self, role: str, endpoint: str, detail: str) -> None:
        """Create the error for one endpoint."""
        self.endpoint = endpoint
        super().__init__(
            f"the {role} cannot listen on {endpoint} ({detail}); stop the process that "
            "uses it or choose another with --listen tcp/127.0.0.1:PORT"
        )


class AlreadyRunning(ServiceError):
    """Another service of this user's serves the same already.

    Attributes:
        role: 'controller' or 'learner'.
        subject: The robot, or the learner's database file.
        pid: Number of the first one's process, if it said so.
        endpoint: Where the first one listens.
        since: ISO 8601, UTC.
    """

    code = "already_running"
    role: str | None = None
    subject: str | None = None
    pid: int | None = None
    endpoint: str | None = None
    since: str | None = None

    def __init__(
        self,
        role: str,
        subject: str,
        pid: int | None = None,
        endpoint: str | None = None,
        since: str | None = None,
    ) -> None:
        """Create the error for one service that was there first."""
        self.role = role
        self.subject = subject
        self.pid = pid
        self.endpoint = endpoint
        self.since = since
        first = "it is starting" if pid is None else f"process {pid} at {endpoint} since {since}"
        stop = "stop it" if pid is None else f"stop it with 'kill {pid}'"
        super().__init__(
            f"there is a {role} for {subject} already ({first}); use that one, or {stop} first; "
            "'tsd status' lists what runs here"
        )


class RunDirectoryUnusable(ServiceError):
    """The folder in which services say that they run cannot be used.

    Attributes:
        path: The folder.
        reason: What is wrong with it.
    """

    code = "run_directory"
    path: Path | None = None
    reason: str | None = None

    def __init__(self, path: Path, reason: str) -> None:
        """Create the error for one folder."""
        self.path = path
        self.reason = reason
        super().__init__(
            f"{path} cannot be the folder of what runs here: {reason}; expected a folder that "
            f"only you can enter ('chmod 700 {path}' if it is yours), or set TSD_RUN_DIR to one"
        )


class CertificateRefused(ServiceError):
    """A certificate is missing, expired, or not one that the other end accepts.

    Attributes:
        endpoint: Where the certificate was shown, or that it is for.
        reason: What is wrong with it.
    """

    code = "certificate"
    endpoint: str | None = None
    reason: str | None = None

    def __init__(self, endpoint: str, reason: str, remedy: str) -> None:
        """Create the error for one certificate."""
        self.endpoint = endpoint
        self.reason = reason
        super().__init__(f"no trust between this end and {endpoint}: {reason}; {remedy}")


class TwoServices(ServiceError):
    """Two services answer for one robot."""

    code = "two_services"
