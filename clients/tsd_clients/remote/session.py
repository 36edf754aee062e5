"""A client's Zenoh session: queries with an outcome that is never ambiguous."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import zenoh

from tsd_casadi.exceptions import MalformedMessage, ServiceUnreachable, TwoServices
from tsd_casadi.wire.endpoints import check_endpoint, configure_runtime, session_settings
from tsd_casadi.wire.error import ErrorMessage
from tsd_casadi.wire.keys import alive_key

# how long a service may take to appear after a client started
PATIENCE = 5.0  # s


class Session:
    """A session connected to explicit endpoints.

    Attributes:
        role: Role of the service that is talked to.
        endpoints: Where it is looked for.
        zenoh: The Zenoh session.
    """

    def __init__(self, role: str, endpoints: Sequence[str], *, low_latency: bool = False) -> None:
        """Connect.

        Args:
            role: 'controller' or 'learner'.
            low_latency: See ``session_settings``.

        Raises:
            InvalidValue: If an endpoint is malformed.
            ServiceUnreachable: If Zenoh cannot open the session.
        """
        self.role = role
        self.endpoints = [check_endpoint(endpoint) for endpoint in endpoints]
        configure_runtime()
        zenoh.init_log_from_env_or("off")
        config = zenoh.Config()
        settings = session_settings(connect=self.endpoints, low_latency=low_latency)
        for key, value in settings.items():
            config.insert_json5(key, value)
        try:
            self.zenoh: Any = zenoh.open(config)
        except zenoh.ZError as error:
            raise ServiceUnreachable(role, self.endpoints, str(error)) from error

    def close(self) -> None:
        """Close the session."""
        self.zenoh.close()

    def wait_for(self, robot: str, patience: float = PATIENCE) -> None:
        """Wait until the service's liveliness token is there.

        Args:
            robot: Robot's chunk of the keys.
            patience: How long [s].

        Raises:
            ServiceUnreachable: If it does not appear.
        """
        end = time.monotonic() + patience
        others: set[str] = set()
        while time.monotonic() < end:
            for reply in self.zenoh.liveliness().get(alive_key("*", self.role), timeout=1.0):
                if reply.ok is None:
                    continue
                key = zenoh.KeyExpr(str(reply.ok.key_expr))
                if key.intersects(zenoh.KeyExpr(alive_key(robot, self.role))):
                    return
                others.add(str(key).split("/")[1])
            time.sleep(0.05)
        detail = f"waited {patience:g} s"
        if others:
            detail = f"there it serves robot {', '.join(sorted(others))}, not {robot}"
        raise ServiceUnreachable(self.role, self.endpoints, detail)

    def query(
        self,
        key: str,
        *,
        parameters: dict[str, str] | None = None,
        payload: bytes | None = None,
        timeout: float = 10.0,
    ) -> list[bytes]:
        """Ask all services on a key.

        Args:
            parameters: Parameters of the selector.
            payload: Body of the query.
            timeout: How long to wait [s].

        Returns:
            The bodies of all replies, at least one.

        Raises:
            TsdError: What a service replied with, as the class that the library raises.
            ServiceUnreachable: If nobody answered in time.
        """
        try:
            replies = self.zenoh.get(
                zenoh.Selector(key, parameters or {}),
                payload=payload,
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                timeout=timeout,
            )
        except zenoh.ZError as error:
            raise ServiceUnreachable(self.role, self.endpoints, str(error)) from error
        bodies = []
        silence = ServiceUnreachable(self.role, self.endpoints, "no reply")
        for reply in replies:
            try:
                bodies.append(self.body_of(reply))
            except ServiceUnreachable as error:
                silence = error  # of one of them: another may have answered
        if not bodies:
            raise silence
        return bodies

    def query_one(
        self, key: str, *, parameters: dict[str, str] | None = None, payload: bytes | None = None
    ) -> bytes:
        """Ask the only service on a key.

        Args:
            parameters: Parameters of the selector.
            payload: Body of the query.

        Returns:
            The body of its reply.

        Raises:
            TsdError: What it replied with, as the class that the library raises.
            ServiceUnreachable: If nobody answered in time.
            TwoServices: If more than one answered.
        """
        bodies = self.query(key, parameters=parameters, payload=payload)
        if len(bodies) > 1:
            raise TwoServices(
                f"{len(bodies)} {self.role}s answer at {', '.join(self.endpoints)}; stop all "
                "but one, or connect to one endpoint"
            )
        return bodies[0]

    def body_of(self, reply: Any) -> bytes:
        """Take the body of a reply.

        Raises:
            TsdError: If it is an error of the service, as the class that the library raises.
            ServiceUnreachable: If it is Zenoh's timeout.
        """
        if reply.ok is not None:
            return bytes(reply.ok.payload.to_bytes())
        body = reply.err.payload.to_bytes()
        try:
            error = ErrorMessage.decode(body)
        except MalformedMessage:
            # Zenoh's own words, "Timeout" among them
            text = body.decode(errors="replace")
            raise ServiceUnreachable(self.role, self.endpoints, text) from None
        raise error.error()
