"""A client's Zenoh session: queries with an outcome that is never ambiguous."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from typing import Any

import zenoh

from tsd_casadi.exceptions import InvalidValue, MalformedMessage, ServiceUnreachable, TwoServices
from tsd_casadi.wire.certificates import Certificates
from tsd_casadi.wire.endpoints import check_endpoint
from tsd_casadi.wire.error import ErrorMessage
from tsd_casadi.wire.keys import alive_key
from tsd_casadi.wire.session_settings import configure_runtime, session_settings
from tsd_casadi.wire.zenoh_file import ZenohFile
from tsd_clients.remote.silence import explain_silence, silence_of

# how long a service may take to appear after a client started
PATIENCE = 5.0  # s
# for an answer; what a service has to compute takes a second or so on a busy machine
ANSWER = 10.0  # s


class Session:
    """A session connected to explicit endpoints.

    Attributes:
        role: Role of the service that is talked to.
        endpoints: Where it is looked for.
        zenoh: The Zenoh session.
    """

    def __init__(
        self, role: str, endpoints: Sequence[str], *, zenoh_file: ZenohFile | None = None
    ) -> None:
        """Connect.

        Args:
            role: 'controller' or 'learner'.
            zenoh_file: Certificates and what else the network needs.

        Raises:
            InvalidValue: If an endpoint or the file is malformed.
            CertificateRefused: If one of the two ends does not trust the other.
            ServiceUnreachable: If Zenoh cannot open the session.
        """
        self.role = role
        self.endpoints = [check_endpoint(endpoint) for endpoint in endpoints]
        if zenoh_file is not None:
            certificates = Certificates.of(zenoh_file, "connect")
            for endpoint in self.endpoints:
                if endpoint.startswith("tls/"):
                    certificates.check_own(endpoint, "connect")
                    certificates.check_other(endpoint)
        settings = session_settings(connect=self.endpoints)
        if zenoh_file is not None:
            settings = zenoh_file.applied_to(settings)
        configure_runtime()
        zenoh.init_log_from_env_or("off")
        try:
            config = zenoh.Config.from_json5(json.dumps(settings))
        except zenoh.ZError as error:
            raise InvalidValue("--zenoh-config", str(error), "what Zenoh knows") from error
        try:
            self.zenoh: Any = zenoh.open(config)
        except zenoh.ZError as error:
            raise ServiceUnreachable(role, self.endpoints, str(error)) from error

    def close(self) -> None:
        """Close the session."""
        self.zenoh.close()

    def alive(self) -> list[tuple[str, str]]:
        """List robot and role of the services that are there, by their liveliness tokens."""
        replies = self.zenoh.liveliness().get(alive_key("*", self.role), timeout=1.0)
        keys = [str(reply.ok.key_expr).split("/") for reply in replies if reply.ok is not None]
        return [(key[1], key[2]) for key in keys]

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
            for name, role in self.alive():
                key = zenoh.KeyExpr(alive_key(name, role))
                if key.intersects(zenoh.KeyExpr(alive_key(robot, self.role))):
                    return
                others.add(name)
            time.sleep(0.05)
        if others:
            detail = f"there it serves robot {', '.join(sorted(others))}, not {robot}"
        else:
            detail = f"waited {patience:g} s; {explain_silence(self.role, self.endpoints)}"
        raise ServiceUnreachable(self.role, self.endpoints, detail)

    def query(
        self,
        key: str,
        *,
        parameters: dict[str, str] | None = None,
        payload: bytes | None = None,
        timeout: float = ANSWER,
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
            ServiceBusy: If a service that is there did not answer in time.
            ServiceUnreachable: If nobody is there to answer.
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
        bodies, words = [], "no reply"
        for reply in replies:
            try:
                bodies.append(self.body_of(reply))
            except ServiceUnreachable:
                # of one of them: another may have answered
                words = f"no reply in {timeout:g} s"
        if not bodies:
            raise silence_of(self.role, self.endpoints, words, timeout if self.alive() else None)
        return bodies

    def query_one(
        self,
        key: str,
        *,
        parameters: dict[str, str] | None = None,
        payload: bytes | None = None,
        timeout: float = ANSWER,
    ) -> bytes:
        """Ask the only service on a key.

        Args:
            parameters: Parameters of the selector.
            payload: Body of the query.
            timeout: How long to wait [s].

        Returns:
            The body of its reply.

        Raises:
            TsdError: What it replied with, as the class that the library raises.
            ServiceBusy: If it is there but did not answer in time.
            ServiceUnreachable: If nobody is there to answer.
            TwoServices: If more than one answered.
        """
        bodies = self.query(key, parameters=parameters, payload=payload, timeout=timeout)
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
