"""A service does not answer."""

from __future__ import annotations

from collections.abc import Sequence

from tsd_casadi.exceptions.services import ServiceError


class ServiceUnreachable(ServiceError):
    """No service answered.

    Attributes:
        role: 'controller' or 'learner'.
        endpoints: Where it was looked for.
    """

    code = "unreachable"
    role: str | None = None
    endpoints: list[str] | None = None

    def __init__(self, role: str, endpoints: Sequence[str], detail: str) -> None:
        """Create the error for one service."""
        self.role = role
        self.endpoints = list(endpoints)
        super().__init__(
            f"no {role} answered at {', '.join(endpoints)} ({detail}); start one with "
            f"'tsd {role}', or name its endpoint with --connect"
        )


class ServiceBusy(ServiceUnreachable):
    """A service that is there did not answer in time.

    What it was asked for may still happen.

    Attributes:
        timeout: How long was waited for it [s].
    """

    code = "busy"
    timeout: float | None = None

    def __init__(self, role: str, endpoints: Sequence[str], timeout: float) -> None:
        """Create the error for one service."""
        self.role = role
        self.endpoints = list(endpoints)
        self.timeout = timeout
        look = "'tsd status' tells how it is"
        if role == "learner":
            look = "'tsd database list' shows what it recorded"
        # not the words of the class above: there is nothing to be started
        ServiceError.__init__(
            self,
            f"the {role} at {', '.join(endpoints)} is there but did not answer within "
            f"{timeout:g} s; it may still be at work: {look}",
        )


class ControllerSilent(ServiceError):
    """A robot was held for longer than the user's patience.

    Attributes:
        patience: How long answers were missing [s].
        why: Of the last one, as far as it can be told.
    """

    code = "controller_silent"
    patience: float | None = None
    why: str | None = None

    def __init__(self, patience: float, why: str) -> None:
        """Create the error for one silence."""
        self.patience = patience
        self.why = why
        super().__init__(
            f"no torque was answered for {patience:g} s ({why}), all of it stepped with the "
            "fallback; look at the controller, or wait for it longer with --patience"
        )
