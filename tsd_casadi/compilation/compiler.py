"""The C compiler: where it is, what it is, and how it is run."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shlex
import shutil
import signal
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from tsd_casadi.exceptions import CompilationFailed, CompilerNotFound, InvalidValue

COMPILERS = ("cc", "gcc", "clang")
FLAGS = ("-O3", "-march=native", "-std=gnu11", "-fPIC", "-shared", "-fno-math-errno")
# how often to look whether a signal came while the compiler runs [s]
GLANCE = 0.1
# how long a busy machine may take to take away the memory of what was killed [s]
DYING = 0.7


def find_compiler() -> str:
    """Path of the C compiler: the one in CC, or the first of cc, gcc, clang.

    Raises:
        CompilerNotFound: If there is none.
        InvalidValue: If CC is no command.
    """
    candidates = tuple(_words_of_cc()[:1]) or COMPILERS
    for candidate in candidates:
        path = shutil.which(candidate)
        if path is not None:
            return path
    raise CompilerNotFound(candidates)


def compiler_key() -> str:
    """Short hash of the compiler's command and of what it says of its version.

    Raises:
        CompilerNotFound: If there is none.
        CompilationFailed: If it cannot be run.
        InvalidValue: If CC is no command.
    """
    command = [*_command(), "--version"]
    try:
        run = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            check=False,
        )
    except OSError as error:
        raise CompilationFailed(command, str(error)) from error
    return hashlib.sha256(repr(command).encode() + run.stdout).hexdigest()[:8]


def solver_folder() -> Path:
    """Folder of CasADi's wheel, which has DAQP and its headers."""
    spec = importlib.util.find_spec("casadi")  # where it is, without importing it
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("casadi", name="casadi")
    return Path(spec.origin).parent


def compile_library(sources: Mapping[str, str], build: Path, came: Sequence[int] = ()) -> Path:
    """Compile C sources into a shared library.

    Args:
        sources: Source text by file name; files ending in '.c' are compiled.
        build: Empty folder, which takes all files of the compilation.
        came: Grows when the compilation is to be given up, from ``held_signals``.

    Returns:
        The shared library.

    Raises:
        CompilerNotFound: If there is no compiler.
        CompilationFailed: If it refuses or cannot be run.
        KeyboardInterrupt: If it was given up.
    """
    for name, text in sources.items():
        (build / name).write_text(text)
    solver = solver_folder()
    built = build / "controller.so"
    command = [
        *_command(),
        *FLAGS,
        f"-I{solver / 'include' / 'daqp'}",
        *[str(build / name) for name in sources if name.endswith(".c")],
        f"-L{solver}",
        "-ldaqp",
        f"-Wl,-rpath,{solver}",
        "-lm",
        "-o",
        str(built),
    ]
    # the compiler's own temporary files go with the folder
    environment = {**os.environ, "TMPDIR": str(build)}
    try:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env=environment,
            process_group=0,  # with all that it starts, so that all of it can be ended
        )
    except OSError as error:
        raise CompilationFailed(command, str(error)) from error
    with process:
        try:
            output = _wait(process, came)
        except BaseException:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            with suppress(subprocess.TimeoutExpired):
                process.communicate(timeout=DYING)  # until the last one let go of the pipe
            raise
    if process.returncode != 0 or not built.is_file():
        raise CompilationFailed(command, output)
    return built


def _wait(process: subprocess.Popen[str], came: Sequence[int]) -> str:
    """Wait for what the compiler prints; a wait without end would not notice a signal."""
    while True:
        try:
            return process.communicate(timeout=GLANCE)[0]
        except subprocess.TimeoutExpired:
            if came:
                raise KeyboardInterrupt from None


def _command() -> list[str]:
    """Find the compiler with the arguments that CC may hold."""
    return [find_compiler(), *_words_of_cc()[1:]]


def _words_of_cc() -> list[str]:
    text = os.environ.get("CC", "")
    try:
        return shlex.split(text)
    except ValueError as error:
        raise InvalidValue(
            "the variable CC",
            f"{text!r} ({str(error).lower()})",
            "a command with its arguments, such as 'gcc -m64'",
        ) from error
