"""The compiled controller, called in the same process."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Protocol

import numpy as np

from tsd_casadi.exceptions import InvalidValue, NotLoadable
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.layout import QUATERNION_TOLERANCE
from tsd_casadi.tick.tick import Tick

_Doubles = ctypes.POINTER(ctypes.c_double)


class WholeBodyController(Protocol):
    """What local and remote controllers have in common."""

    @property
    def format(self) -> TickFormat:
        """What the numbers of requests and replies mean."""

    def command(self) -> Command:
        """Make a new command, which holds the home posture."""

    def tick(self, state: State, command: Command) -> Tick:
        """Compute the torque for one state and command."""


class Controller:
    """A compiled controller.

    One controller serves one thread at a time; ticks have no memory, so any
    number of simulators may take turns.

    Attributes:
        format: The meaning of requests and replies.
        library: The shared library.
    """

    def __init__(self, tick_format: TickFormat, library: Path) -> None:
        """Load a compiled problem.

        Args:
            library: Its shared library, from ``compile_controller``.

        Raises:
            NotLoadable: If the system does not load it.
        """
        self.format = tick_format
        self.library = library
        self._context = ctypes.c_void_p()
        try:
            compiled = ctypes.CDLL(str(library))  # a call releases the GIL
        except OSError as error:
            raise NotLoadable(library, str(error)) from error
        compiled.tick_create.argtypes = [_Doubles, _Doubles]
        compiled.tick_create.restype = ctypes.c_void_p
        compiled.tick_free.argtypes = [ctypes.c_void_p]
        compiled.tick_free.restype = None
        compiled.tick_run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
        compiled.tick_run.restype = ctypes.c_int
        self._compiled = compiled
        lower, upper = tick_format.request.lower(), tick_format.request.upper()
        self._context = ctypes.c_void_p(
            compiled.tick_create(lower.ctypes.data_as(_Doubles), upper.ctypes.data_as(_Doubles))
        )
        if not self._context:
            raise MemoryError("no memory for the controller's context")

    def __repr__(self) -> str:
        """Name the robot and the size of its problem."""
        return f"<Controller of {self.format.summary()}>"

    def __del__(self) -> None:
        """Give the context's memory back."""
        if getattr(self, "_context", None):
            self._compiled.tick_free(self._context)

    def command(self) -> Command:
        """Make a new command, which holds the home posture."""
        return Command(self.format.request)

    def tick(self, state: State, command: Command) -> Tick:
        """Compute the torque for one state and command.

        Args:
            command: What to do; its request vector takes the state.

        Returns:
            The tick; look at its status before using more than tau.

        Raises:
            InvalidValue: If a number is not finite or out of range; it names
                the field.
        """
        command.set_state(state)
        return Tick(self.format, self.run(command.request))

    def run(self, request: Vector) -> Vector:
        """Answer a request vector with a reply vector; ``format`` says what they mean.

        Args:
            request: (format.request.size,), contiguous float64.

        Returns:
            The reply, (format.reply.size,).

        Raises:
            InvalidValue: If a number is not finite or out of range, or the
                vector is not what C can read.
        """
        if (
            request.shape != (self.format.request.size,)
            or request.dtype != np.float64
            or not request.flags.c_contiguous
        ):
            raise InvalidValue(
                "request",
                f"{request.dtype} of shape {request.shape}",
                f"contiguous float64 of shape ({self.format.request.size},)",
            )
        reply = np.empty(self.format.reply.size)
        refused = self._compiled.tick_run(self._context, request.ctypes.data, reply.ctypes.data)
        if refused:
            raise self._refusal(request, refused - 1)
        return reply

    def _refusal(self, request: Vector, index: int) -> InvalidValue:
        field, position = self.format.request.locate(index)
        value = float(request[index])
        name = field.name if field.size == 1 else f"{field.name}[{position}]"
        if field.switch and np.isfinite(value):
            return InvalidValue(name, value, "0 or 1")
        if field.unit_quaternion == position and field.lower <= value <= field.upper:
            norm = float(np.linalg.norm(request[index : index + 4]))
            return InvalidValue(
                f"the norm of the quaternion in {field.name}",
                norm,
                f"1 within {QUATERNION_TOLERANCE} (order x y z w)",
            )
        return InvalidValue(
            name, value, f"a finite number from {field.lower:g} to {field.upper:g}, {field.unit}"
        )
