"""Every error this project raises, in one hierarchy.

Each class carries its data as attributes; the message says what was wrong,
what was expected and what to do about it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any


class TsdError(Exception):
    """Base class of all errors raised on purpose.

    Attributes:
        code: Short machine-readable name, used in error replies.
    """

    code = "error"

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by attributes, since the constructors' arguments differ."""
        return _restore, (type(self), self.args, self.__dict__)


def _restore(kind: type[TsdError], arguments: tuple[Any, ...], data: dict[str, Any]) -> TsdError:
    error = kind.__new__(kind)
    error.args = arguments
    error.__dict__.update(data)
    return error


class RobotFileError(TsdError):
    """A robot file, or a file it names, cannot be used.

    Attributes:
        path: The file.
        field: Dotted path of the offending field, empty for the whole file.
        expected: What was expected there.
    """

    code = "robot_file"

    def __init__(self, path: Path, field: str, found: str, expected: str) -> None:
        """Create the error for one field of one file."""
        self.path = path
        self.field = field
        self.expected = expected
        where = f"field '{field}'" if field else "file"
        super().__init__(f"{path}: {where}: {found}; expected {expected}")


class UnknownRobot(TsdError):
    """No shipped robot has that name and no file is there.

    Attributes:
        name: What was asked for.
        known: Names of the shipped robots.
    """

    code = "unknown_robot"

    def __init__(self, name: str, known: Sequence[str]) -> None:
        """Create the error for one name."""
        self.name = name
        self.known = list(known)
        super().__init__(
            f"no robot '{name}'; expected one of {', '.join(known)}, "
            "or the path of a robot file (.yaml)"
        )


class UnknownField(TsdError, KeyError):
    """A vector has no field of that name.

    Attributes:
        name: What was asked for.
        known: The fields there are.
    """

    code = "unknown_field"

    def __init__(self, name: str, known: Sequence[str]) -> None:
        """Create the error for one name."""
        self.name = name
        self.known = list(known)
        super().__init__(f"no field '{name}'; there are {', '.join(known)}")

    def __str__(self) -> str:
        """Message without the quotes that KeyError adds."""
        return str(self.args[0])


class InvalidValue(TsdError, ValueError):
    """A number is outside its range or not a number.

    Attributes:
        field: Name of the quantity, with its index where it has one.
        value: What was given.
        expected: What was expected.
    """

    code = "invalid_value"

    def __init__(self, field: str, value: object, expected: str) -> None:
        """Create the error for one value."""
        self.field = field
        self.value = value
        self.expected = expected
        super().__init__(f"{field} is {value}, expected {expected}")


class MalformedMessage(TsdError, ValueError):
    """Bytes or JSON from the network cannot be read.

    Attributes:
        expected: What was expected.
    """

    code = "malformed"

    def __init__(self, found: str, expected: str) -> None:
        """Create the error for one message."""
        self.expected = expected
        super().__init__(f"{found}; expected {expected}")


class UnsupportedVersion(MalformedMessage):
    """A message speaks another version of the protocol."""

    code = "version"


class LayoutMismatch(MalformedMessage):
    """A message was packed for another formulation or robot."""

    code = "layout"


class CompilerNotFound(TsdError):
    """No C compiler is on the path.

    Attributes:
        tried: The commands that were looked for.
    """

    code = "no_compiler"

    def __init__(self, tried: Sequence[str]) -> None:
        """Create the error for the commands tried."""
        self.tried = list(tried)
        super().__init__(
            f"no C compiler found (tried {', '.join(tried)}): install one, for instance "
            "'apt install gcc' on Debian or Ubuntu, 'dnf install gcc' on Fedora, "
            "'xcode-select --install' on macOS, or name yours in the variable CC"
        )


class CompilationFailed(TsdError):
    """The C compiler refused the generated code.

    Attributes:
        command: The command line.
        output: What the compiler printed.
    """

    code = "compilation"

    def __init__(self, command: Sequence[str], output: str) -> None:
        """Create the error for one compiler run."""
        self.command = list(command)
        self.output = output
        tail = "\n".join(output.strip().splitlines()[-8:])
        super().__init__(
            f"the compiler failed: {' '.join(command)}\n{tail}\n"
            "check the compiler named by CC, free disk space and memory"
        )


class CacheNotPrivate(TsdError):
    """The folder of compiled code is not one that only the user can write to.

    Attributes:
        path: The folder.
        reason: Why it is not used.
    """

    code = "cache_not_private"

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


class ParityError(TsdError):
    """Two descriptions of one robot disagree.

    Attributes:
        quantity: What was compared.
        difference: Largest absolute difference.
    """

    code = "parity"

    def __init__(self, robot: str, quantity: str, difference: float, allowed: float) -> None:
        """Create the error for one quantity."""
        self.quantity = quantity
        self.difference = difference
        super().__init__(
            f"robot '{robot}': {quantity} from the URDF and from the MuJoCo scene differ "
            f"by {difference:.3g}, expected at most {allowed:.0e}; compare masses, "
            "inertias, joint axes and placements in the two files"
        )


class DatabaseError(TsdError):
    """A database file cannot be used.

    Attributes:
        path: The file.
    """

    code = "database"

    def __init__(self, path: Path, found: str, remedy: str) -> None:
        """Create the error for one file."""
        self.path = path
        super().__init__(f"database {path}: {found}; {remedy}")


class EntryNotFound(TsdError):
    """The database has no entry for that question."""

    code = "not_found"


class OutsideTrainedRange(TsdError):
    """A query lies outside what was learned.

    Attributes:
        parameter: Name of the task parameter.
        value: What was asked for.
        low: Smallest learned value.
        high: Largest learned value.
    """

    code = "extrapolation"

    def __init__(self, parameter: str, value: float, low: float, high: float, unit: str) -> None:
        """Create the error for one parameter."""
        self.parameter = parameter
        self.value = value
        self.low = low
        self.high = high
        super().__init__(
            f"{parameter} {value:g} {unit} is outside the learned range "
            f"{low:g} to {high:g} {unit}; learn an entry beyond it, or ask with "
            "extrapolate=true"
        )


class IncompatibleEntry(TsdError):
    """A recording cannot be joined to what the database holds."""

    code = "incompatible"


class ServiceUnreachable(TsdError):
    """No service answered.

    Attributes:
        role: 'controller' or 'learner'.
        endpoints: Where it was looked for.
    """

    code = "unreachable"

    def __init__(self, role: str, endpoints: Sequence[str], detail: str) -> None:
        """Create the error for one service."""
        self.role = role
        self.endpoints = list(endpoints)
        super().__init__(
            f"no {role} answered at {', '.join(endpoints)} ({detail}); start one with "
            f"'tsd {role}', or name its endpoint with --connect"
        )


class ServiceError(TsdError):
    """A service answered with an error.

    Attributes:
        code: The service's error code.
    """

    def __init__(self, code: str, message: str) -> None:
        """Create the error from a reply's fields."""
        self.code = code
        super().__init__(message)


class EndpointTaken(TsdError):
    """Another process listens on the endpoint already.

    Attributes:
        endpoint: The endpoint.
    """

    code = "endpoint_taken"

    def __init__(self, role: str, endpoint: str, detail: str) -> None:
        """Create the error for one endpoint."""
        self.endpoint = endpoint
        super().__init__(
            f"the {role} cannot listen on {endpoint} ({detail}); stop the process that "
            "uses it or choose another with --listen tcp/127.0.0.1:PORT"
        )


class TwoServices(TsdError):
    """Two services answer for one robot."""

    code = "two_services"


class SimulationError(TsdError):
    """A simulation could not be carried out as asked."""

    code = "simulation"
