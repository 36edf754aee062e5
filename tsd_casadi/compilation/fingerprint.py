"""What a compiled controller depends on, without building anything symbolic."""

from __future__ import annotations

import hashlib
import importlib.machinery
import importlib.metadata
import importlib.util
from functools import cache
from pathlib import Path

# packages of ours whose text decides what is generated
PACKAGES = (
    "tsd_casadi.robot",
    "tsd_casadi.dynamics",
    "tsd_casadi.constraints",
    "tsd_casadi.tasks",
    "tsd_casadi.costs",
    "tsd_casadi.tick",
    "tsd_casadi.formulation",
    "tsd_casadi.compilation",
    "pinocchio_casadi",
)
LIBRARIES = ("casadi", "pin")
TEXTS = (".py", ".c", ".h")


@cache
def formulation_fingerprint() -> str:
    """Hash the text of the formulation and the versions of the libraries that read it.

    Two robots with equal files and equal formulation fingerprints have the same
    compiled controller. A comment changes it as well: that costs building the
    symbolic problem once, not compiling it.

    Returns:
        32 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for name in LIBRARIES:
        digest.update(f"{name} {importlib.metadata.version(name)}\0".encode())
    for package in PACKAGES:
        for folder in _folders(package):
            for path in sorted(folder.rglob("*")):
                if path.suffix in TEXTS:
                    digest.update(f"{package} {path.relative_to(folder)}\0".encode())
                    digest.update(path.read_bytes())
                elif path.suffix in importlib.machinery.EXTENSION_SUFFIXES or ".so" in path.name:
                    status = path.stat()  # megabytes: its size and date will do
                    digest.update(f"{path.name} {status.st_size} {status.st_mtime_ns}".encode())
    return digest.hexdigest()[:32]


def _folders(package: str) -> list[Path]:
    spec = importlib.util.find_spec(package)
    if spec is None or spec.submodule_search_locations is None:
        raise ModuleNotFoundError(package, name=package)
    return sorted(Path(folder) for folder in spec.submodule_search_locations)
