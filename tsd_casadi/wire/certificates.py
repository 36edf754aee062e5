"""What is wrong with a certificate, before Zenoh can only say that nobody answers.

A handshake of Python's own tells it: in memory for this end's certificate, over the
network for that of a service and for what the service thinks of ours.
"""

from __future__ import annotations

import ssl
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from socket import create_connection
from typing import Any

from tsd_casadi.exceptions import CertificateRefused
from tsd_casadi.wire.zenoh_file import ZenohFile

# for a connection, and then for the service to say that it refuses our certificate;
# Zenoh's listener takes 0.1 s to say so [s]
CONNECTING, REFUSING = 2.0, 0.5
# OpenSSL's numbers of what verification found
_EXPIRED, _NOT_YET = 10, 9
_UNKNOWN_AUTHORITY = (2, 18, 19, 20, 21)
_WRONG_HOST = (62, 64)
# alerts of the other end, by a part of their names
_ALERTS = {
    "CERTIFICATE_REQUIRED": "it asks for a certificate and this end has none",
    "CERTIFICATE_EXPIRED": "this end's certificate has expired",
    "UNKNOWN_CA": "this end's certificate is from an authority that it does not know",
}
_RENEW = "make a new one with the same authority"


@dataclass(frozen=True)
class Certificates:
    """The files of one end.

    Attributes:
        authority: Of the certificates that are trusted; None for those of the system.
        certificate: This end's, if it has one.
        key: Belongs to it.
        checks_host: Whether a service's certificate has to name its host.
    """

    authority: str | None
    certificate: str | None
    key: str | None
    checks_host: bool

    @classmethod
    def of(cls, file: ZenohFile, side: str) -> Certificates:
        """Find the files that a configuration names.

        Args:
            side: 'listen' or 'connect'.
        """
        tls = file.section("transport", "link", "tls")
        # Zenoh shows a client's certificate only then
        is_shown = side == "listen" or tls.get("enable_mtls") is True
        return cls(
            authority=tls.get("root_ca_certificate"),
            certificate=tls.get(f"{side}_certificate") if is_shown else None,
            key=tls.get(f"{side}_private_key") if is_shown else None,
            checks_host=tls.get("verify_name_on_connect") is not False,
        )

    def check_own(self, endpoint: str, side: str) -> None:
        """Refuse a certificate of this end that nobody could accept.

        Args:
            endpoint: What it is for.
            side: 'listen' or 'connect'.

        Raises:
            CertificateRefused: If a file is missing or cannot be read, the key is
                another's, or the certificate has expired or is another authority's.
        """
        for path in (self.authority, self.certificate, self.key):
            if path is not None and not Path(path).is_file():
                raise CertificateRefused(
                    endpoint, f"{path} is missing", "name the file in --zenoh-config"
                )
        if self.certificate is None or self.key is None:
            if side == "listen":
                raise CertificateRefused(
                    endpoint,
                    "a service without a certificate cannot listen with TLS",
                    "name listen_certificate and listen_private_key in --zenoh-config",
                )
            return
        showing = self._context(ssl.PROTOCOL_TLS_SERVER, endpoint)
        checking = self._context(ssl.PROTOCOL_TLS_CLIENT, endpoint)
        checking.check_hostname = False
        if self.authority is None:
            checking.verify_mode = ssl.CERT_NONE
        if side == "connect":
            # the same certificate, shown by the end that connects
            checking.verify_mode = ssl.CERT_NONE
            if self.authority is not None:
                showing.verify_mode = ssl.CERT_REQUIRED
        try:
            _shake_hands(showing, checking)
        except ssl.SSLCertVerificationError as error:
            reason = _of_verification(error, f"{self.certificate}")
            raise CertificateRefused(endpoint, reason, _RENEW) from error
        except ssl.SSLError as error:
            raise CertificateRefused(
                endpoint, f"{self.certificate}: {error.reason}", _RENEW
            ) from error

    def check_other(self, endpoint: str) -> None:
        """Refuse a service whose certificate is not to be trusted, or that refuses ours.

        Nothing is said about a service that is not there.

        Args:
            endpoint: 'tls/HOST:PORT'.

        Raises:
            CertificateRefused: If one of the two certificates is not accepted.
        """
        host, port = endpoint.removeprefix("tls/").rsplit(":", 1)
        host = host.strip("[]")
        context = self._context(ssl.PROTOCOL_TLS_CLIENT, endpoint)
        context.check_hostname = self.checks_host
        try:
            with (
                create_connection((host, int(port)), timeout=CONNECTING) as connection,
                context.wrap_socket(connection, server_hostname=host) as secured,
                suppress(TimeoutError),  # it says nothing, so it has nothing against ours
            ):
                secured.settimeout(REFUSING)
                secured.recv(1)
        except ssl.SSLCertVerificationError as error:
            reason = _of_verification(error, "its certificate", host)
            raise CertificateRefused(
                endpoint, reason, "give the service another one, or name its authority"
            ) from error
        except ssl.SSLError as error:
            raise CertificateRefused(
                endpoint,
                _of_alert(error),
                "see connect_certificate, connect_private_key and enable_mtls in --zenoh-config",
            ) from error
        except OSError:
            return

    def _context(self, protocol: Any, endpoint: str) -> ssl.SSLContext:
        context = ssl.SSLContext(protocol)
        try:
            if self.authority is None:
                context.load_default_certs()
            else:
                context.load_verify_locations(self.authority)
            if self.certificate is not None and self.key is not None:
                context.load_cert_chain(self.certificate, self.key)
        except (OSError, ssl.SSLError) as error:
            reason = getattr(error, "reason", None) or str(error)
            files = ", ".join(str(each) for each in (self.authority, self.certificate, self.key))
            raise CertificateRefused(
                endpoint, f"{files} cannot be used: {reason}", "expected PEM files that fit"
            ) from error
        return context


def _shake_hands(server: ssl.SSLContext, client: ssl.SSLContext) -> None:
    """Let two ends meet in memory."""
    up, down = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = [
        client.wrap_bio(down, up, server_hostname="localhost"),
        server.wrap_bio(up, down, server_side=True),
    ]
    for _ in range(4):  # more than a handshake has flights
        for end in ends:
            with suppress(ssl.SSLWantReadError):
                end.do_handshake()


def _of_verification(error: ssl.SSLCertVerificationError, whose: str, host: str = "") -> str:
    if error.verify_code == _EXPIRED:
        return f"{whose} has expired"
    if error.verify_code == _NOT_YET:
        return f"{whose} is not valid yet; look at both clocks"
    if error.verify_code in _UNKNOWN_AUTHORITY:
        return f"{whose} is from an authority that this end does not know"
    if error.verify_code in _WRONG_HOST:
        return f"{whose} is for another host than {host}"
    return f"{whose} is not valid: {error.verify_message}"


def _of_alert(error: ssl.SSLError) -> str:
    name = error.reason or str(error)
    for part, meaning in _ALERTS.items():
        if part in name:
            return meaning
    if "WRONG_VERSION_NUMBER" in name or "UNEXPECTED_EOF" in name:
        return "it does not speak TLS"
    return f"the TLS handshake failed ({name})"
