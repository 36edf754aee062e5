"""The controller cannot be compiled, kept or loaded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tsd_casadi.exceptions.base import TsdError


class ControllerError(TsdError):
    """What keeps a controller from being made."""


class CompilerNotFound(ControllerError):
    """No C compiler is on the path.

    Attributes:
        tried: The commands that were looked for.
    """

    code = "no_compiler"
    tried: list[str] | None = None

    def __init__(self, tried: Sequence[str]) -> None:
        """Create the error for the commands tried."""
        self.tried = list(tried)
        super().__init__(
            f"no C compiler found (tried {', '.join(tried)}): install one, for instance "
            "'apt install gcc' on Debian or Ubuntu, 'dnf install gcc' on Fedora, "
            "'xcode-select --install' on macOS, or name yours in the variable CC"
        )


class CompilationFailed(ControllerError):
    """The C compiler refused the generated code.

    Attributes:
        command: The command line.
        output: What the compiler printed.
    """

    code = "compilation"
    command: list[str] | None = None
    output: str | None = None

    def __init__(self, command: Sequence[str], output: str) -> None:
        """Create the error for one compiler run."""
        self.command = list(command)
        self.output = output
        tail = "\n".join(output.strip().splitlines()[-8:])
        super().__init__(
            f"the compiler failed: {' '.join(command)}\n{tail}\n"
            "check the compiler named by CC, free disk space and memory"
        )


class CacheNotPrivate(ControllerError):
    """The folder of compiled code is not one that only the user can write to.

    Attributes:
        path: The folder.
        reason: Why it is not used.
    """

    code = "cache_not_private"
    path: Path | None = None
    reason: str | None = None

    def __init__(
        self, path: Path, reason: str = "belongs to another user or others may write to it"
    ) -> None:
        """Create the error for one folder."""
        self.path = path
        self.reason = reason
        super().__init__(
            f"{path} {reason}, so code from it is not loaded; run 'chmod 700 {path}' if it "
            "is yours, or set TSD_CACHE_DIR to a folder of your own"
        )


class CacheNotWritable(ControllerError):
    """Compiled code cannot be kept in its folder.

    Attributes:
        path: The folder.
        reason: What the system said.
    """

    code = "cache_not_writable"
    path: Path | None = None
    reason: str | None = None

    def __init__(self, path: Path, reason: str) -> None:
        """Create the error for one folder."""
        self.path = path
        self.reason = reason
        super().__init__(
            f"{path} cannot be written to ({reason}); make room there, or set TSD_CACHE_DIR to "
            "a folder that you may write to"
        )


class NotLoadable(ControllerError):
    """Compiled code is there but the system does not load it.

    Attributes:
        path: The shared library.
        reason: What the system said.
    """

    code = "not_loadable"
    path: Path | None = None
    reason: str | None = None

    def __init__(self, path: Path, reason: str) -> None:
        """Create the error for one library."""
        self.path = path
        self.reason = reason
        super().__init__(
            f"{path} cannot be loaded ({reason}); delete it to have it compiled again, or set "
            "TSD_CACHE_DIR to a folder from which programs may run"
        )
