"""A user's Zenoh configuration: certificates, user names, routers."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.wire.endpoints import check_endpoint
from tsd_casadi.wire.session_settings import ACCESS, merged

# strings, which are kept, and JSON5's comments
_COMMENT = re.compile(
    r"""("(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*')|//[^\n]*|/\*.*?\*/""",
    re.DOTALL,
)
# fields with a path, which is relative to the file
_PATHS = (
    ("transport", "link", "tls", "root_ca_certificate"),
    ("transport", "link", "tls", "listen_certificate"),
    ("transport", "link", "tls", "listen_private_key"),
    ("transport", "link", "tls", "connect_certificate"),
    ("transport", "link", "tls", "connect_private_key"),
    ("transport", "auth", "usrpwd", "dictionary_file"),
)


@dataclass(frozen=True)
class ZenohFile:
    """What a user's file says, in the names of Zenoh's own configuration.

    Attributes:
        path: The file.
        settings: Its document; paths in it are absolute.
    """

    path: Path
    settings: dict[str, Any]

    def endpoints(self, side: str) -> list[str]:
        """List the endpoints that the file names.

        Args:
            side: 'listen' or 'connect'.

        Raises:
            InvalidValue: If they are no list of endpoints.
        """
        given = self.section(side).get("endpoints", [])
        if not isinstance(given, list) or not all(isinstance(each, str) for each in given):
            raise InvalidValue(f"{self.path}: {side}.endpoints", given, "a list of endpoints")
        return [check_endpoint(each) for each in given]

    def section(self, *names: str) -> dict[str, Any]:
        """Find a section, empty if the file has none."""
        found: Any = self.settings
        for name in names:
            found = found.get(name) if isinstance(found, Mapping) else None
        return dict(found) if isinstance(found, Mapping) else {}

    def applied_to(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        """Put the file's settings before those of a session of ours.

        Endpoints stay those of the session, which has them from here if nobody named
        others. What services refuse stays refused whatever the file's access list says.
        """
        result = merged(settings, self.settings)
        for side in ("listen", "connect"):
            result[side] = {**result[side], "endpoints": settings[side]["endpoints"]}
        access = self.section("access_control")
        if "access_control" in settings and access:
            joined = {
                name: [*access.get(name, []), *ACCESS[name]]
                for name in ("rules", "subjects", "policies")
            }
            result["access_control"] = {**ACCESS, **access, **joined, "enabled": True}
        return result


def read_zenoh_file(path: Path) -> ZenohFile:
    """Read a file in JSON5, JSON or YAML.

    Raises:
        InvalidValue: If it cannot be read, or is not a document of sections.
    """
    try:
        text = path.read_text()
        document = yaml.safe_load(_COMMENT.sub(r"\1", text) if path.suffix != ".yaml" else text)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InvalidValue(
            "--zenoh-config", f"{path} ({reason})", "a file as Zenoh reads it, JSON5 or YAML"
        ) from error
    if not isinstance(document, dict):
        raise InvalidValue("--zenoh-config", str(path), "a document with sections in braces")
    for *names, last in _PATHS:
        section: Any = document
        for name in names:
            section = section.get(name) if isinstance(section, dict) else None
        if isinstance(section, dict) and isinstance(section.get(last), str):
            section[last] = str(path.parent.absolute() / section[last])
    return ZenohFile(path, document)
