"""Where a service listens, and who can reach it there."""

from __future__ import annotations

import json
import resource
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import zenoh

from tsd_casadi.exceptions import EndpointTaken, InvalidValue
from tsd_casadi.wire.certificates import Certificates
from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER, check_endpoint, is_of_this_machine
from tsd_casadi.wire.session_settings import configure_runtime, session_settings
from tsd_casadi.wire.zenoh_file import ZenohFile, read_zenoh_file

Role = Literal["controller", "learner"]
USUAL: dict[Role, str] = {"controller": CONTROLLER, "learner": LEARNER}
TLS = ("tls/", "quic/")


@dataclass(frozen=True)
class Place:
    """Where a service listens.

    Attributes:
        listen: Endpoints; without any those of the file, or else the role's usual one.
        zenoh_config: A Zenoh configuration: certificates, user names, routers.
        expose: Whether other machines may reach it without such a file.
    """

    listen: Sequence[str] = ()
    zenoh_config: Path | None = None
    expose: bool = False

    def endpoints(self, role: Role) -> list[str]:
        """List where to listen.

        Raises:
            InvalidValue: If an endpoint is malformed, or other machines can reach it
                though nobody said that they may.
        """
        file = self._file()
        found = [check_endpoint(endpoint) for endpoint in self.listen]
        if not found and file is not None:
            found = file.endpoints("listen")
        found = found or [USUAL[role]]
        for endpoint in found:
            if not (is_of_this_machine(endpoint) or self.expose or self.zenoh_config is not None):
                raise InvalidValue(
                    "--listen",
                    f"{endpoint}, which other machines can reach",
                    "an address of this machine such as tcp/127.0.0.1:7447, or --zenoh-config "
                    "with certificates, or --expose if anybody on that network may use it",
                )
        return found

    def open(self, role: Role) -> zenoh.Session:
        """Open the session of a service.

        Raises:
            EndpointTaken: If it cannot listen there.
            InvalidValue: If Zenoh does not know what the file says.
            CertificateRefused: If a certificate cannot be used.
        """
        file, endpoints = self._file(), self.endpoints(role)
        for endpoint in endpoints:
            if endpoint.startswith(TLS) and file is not None:
                Certificates.of(file, "listen").check_own(endpoint, "listen")
        settings = session_settings(listen=endpoints, service=role)
        if file is not None:
            settings["connect"]["endpoints"] = file.endpoints("connect")
            settings = file.applied_to(settings)
        configure_runtime()
        zenoh.init_log_from_env_or("off")
        _allow_many_connections()
        try:
            config = zenoh.Config.from_json5(json.dumps(settings))
        except zenoh.ZError as error:
            raise InvalidValue(
                "--zenoh-config", f"{self.zenoh_config} ({error})", "what Zenoh knows"
            ) from error
        try:
            session = zenoh.open(config)
        except zenoh.ZError as error:
            raise EndpointTaken(role, ", ".join(endpoints), _reason(error)) from error
        for endpoint in endpoints:
            if not is_of_this_machine(endpoint):
                _warn_of_others(role, endpoint, file)
        return session

    def _file(self) -> ZenohFile | None:
        return None if self.zenoh_config is None else read_zenoh_file(self.zenoh_config)


def _warn_of_others(role: Role, endpoint: str, file: ZenohFile | None) -> None:
    tls = {} if file is None else file.section("transport", "link", "tls")
    users = {} if file is None else file.section("transport", "auth", "usrpwd")
    if endpoint.startswith(TLS) and tls.get("enable_mtls"):
        who = f"with a certificate of {tls.get('root_ca_certificate')}"
    elif users.get("dictionary_file"):
        who = f"with a user name of {users['dictionary_file']}"
    else:
        who = "who can reach it, since nothing checks who that is"
    does = "asks for torques" if role == "controller" else "reads and changes what was learned"
    secret = "" if endpoint.startswith(TLS) else " What is said there can be read on the way."
    text = f"WARNING: {endpoint} is open to other machines: anybody {who}, {does}.{secret}"
    with suppress(OSError, ValueError):
        print(text, file=sys.stderr, flush=True)


def _allow_many_connections() -> None:
    """Allow this process as many open files as it may allow itself.

    Each connection is one, and where they are used up Zenoh lets nobody in for a while.
    """
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    with suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


def _reason(error: Exception) -> str:
    # Zenoh's text goes on with its own source lines
    text = str(error)
    if "Address already in use" in text:
        return "the address is already in use"
    return text.split(" at /", maxsplit=1)[0] or type(error).__name__
