"""From a robot to its compiled controller, by the shortest way there is."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable
from pathlib import Path

from tsd_casadi.compilation.code_cache import (
    cache_folder,
    compile_cached,
    keep_text,
    library_key,
    verified_library,
)
from tsd_casadi.compilation.fingerprint import formulation_fingerprint
from tsd_casadi.controller.controller import Controller
from tsd_casadi.robot.robot import Robot
from tsd_casadi.tick.format import TickFormat

_log = logging.getLogger(__name__)


def compile_controller(robot: Robot, on_compile: Callable[[], None] | None = None) -> Controller:
    """Load the controller of a robot; build and compile it where that was never done.

    The compiled code is kept in the user's cache folder, its layouts beside it.
    Both are found there by the fingerprints of robot and formulation, before
    anything symbolic is built.

    Args:
        on_compile: Called before a compilation starts; by default a line of the
            log says that it is under way.

    Returns:
        The controller.

    Raises:
        CompilerNotFound: If it is not in the cache and there is no compiler.
        CompilationFailed: If the compiler refuses.
        CacheNotPrivate: If somebody else could write to the cache.
        CacheNotWritable: If what was compiled cannot be kept.
        NotLoadable: If the system does not load it.
    """
    index = _index_of(robot)
    kept = _read(index)
    if kept is not None:
        return Controller(*kept)
    # CasADi and Pinocchio's part of it, which a compiled controller does without
    from tsd_casadi.compilation.code_generation import generate_sources
    from tsd_casadi.formulation.inverse_dynamics import InverseDynamics

    def announce() -> None:
        _log.warning("compiling the controller of %s (once, about 20 s)", robot.name)

    problem = InverseDynamics(robot)
    library = compile_cached(generate_sources(problem), on_compile or announce)
    _write(index, problem.format, library)
    return Controller(problem.format, library)


def _index_of(robot: Robot) -> Path:
    key = library_key(robot.fingerprint, formulation_fingerprint())
    return cache_folder() / f"{key}.json"


def _read(index: Path) -> tuple[TickFormat, Path] | None:
    """Read what an earlier run left; None if it cannot be used."""
    try:
        kept = json.loads(index.read_text())
        library = verified_library(index.parent / Path(kept["library"]).name)
        tick_format = TickFormat.from_plain(kept["format"])
    except (OSError, ValueError, KeyError, TypeError):
        return None  # never made, or damaged: make it again
    return None if library is None else (tick_format, library)


def _write(index: Path, tick_format: TickFormat, library: Path) -> None:
    kept = {"library": library.name, "format": tick_format.plain()}
    keep_text(index, json.dumps(kept))
