"""The compiled controller, called in the same process."""

from __future__ import annotations

import contextlib
import ctypes
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np

from tsd_casadi.compilation.code_cache import compile_cached
from tsd_casadi.compilation.code_generation import QUATERNION_TOLERANCE, generate_sources
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.format import TickFormat
from tsd_casadi.tick.tick import Tick
from tsd_clients.console.progress import show_activity

_Doubles = ctypes.POINTER(ctypes.c_double)


class WholeBodyController(Protocol):
    """What local and remote controllers have in common."""

    @property
    def format(self) -> TickFormat:
        """The meaning of requests and replies."""

    def command(self) -> Command:
        """A new command that holds the home posture."""

    def tick(self, state: State, command: Command) -> Tick:
        """Torque for one state and command."""


class Controller:
    """A compiled controller.

    One controller serves one thread at a time; ticks have no memory, so any
    number of simulators may take turns.

    Attributes:
        problem: The QP it was compiled from, with named rows.
        format: The meaning of requests and replies.
        library: The shared library.
    """

    def __init__(self, problem: InverseDynamics, library: Path) -> None:
        """Load a compiled problem.

        Args:
            problem: The problem.
            library: Its shared library, from ``compile_cached``.
        """
        self.problem = problem
        self.format: TickFormat = problem.format
        self.library = library
        self._context = ctypes.c_void_p()
        compiled = ctypes.CDLL(str(library))  # a call releases the GIL
        compiled.tick_create.argtypes = [_Doubles, _Doubles]
        compiled.tick_create.restype = ctypes.c_void_p
        compiled.tick_free.argtypes = [ctypes.c_void_p]
        compiled.tick_free.restype = None
        compiled.tick_run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
        compiled.tick_run.restype = ctypes.c_int
        self._compiled = compiled
        lower, upper = problem.request.lower(), problem.request.upper()
        self._context = ctypes.c_void_p(
            compiled.tick_create(lower.ctypes.data_as(_Doubles), upper.ctypes.data_as(_Doubles))
        )
        if not self._context:
            raise MemoryError("no memory for the controller's context")

    def __del__(self) -> None:
        """Give the context's memory back."""
        if getattr(self, "_context", None):
            self._compiled.tick_free(self._context)

    def command(self) -> Command:
        """A new command that holds the home posture."""
        return Command(self.format.request)

    def tick(self, state: State, command: Command) -> Tick:
        """Torque for one state and command.

        Args:
            state: The robot's state.
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
        """The same on bare vectors.

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


def compile_controller(robot: Robot, on_compile: Callable[[], None] | None = None) -> Controller:
    """Build, compile and load the controller of a robot.

    The compiled code is kept in the user's cache folder and found there next
    time.

    Args:
        robot: The robot.
        on_compile: Called before a compilation starts; by default a line on
            stderr shows that it is under way.

    Returns:
        The controller.

    Raises:
        CompilerNotFound: If it is not in the cache and there is no compiler.
        CompilationFailed: If the compiler refuses.
        CacheNotPrivate: If somebody else could write to the cache.
    """
    problem = InverseDynamics(robot)
    sources = generate_sources(problem)
    with contextlib.ExitStack() as stack:

        def show() -> None:
            text = f"compiling the controller of {robot.name} (once, about 20 s)"
            stack.enter_context(show_activity(text))

        library = compile_cached(sources, on_compile or show)
    return Controller(problem, library)
