"""Compiled code by content: the same source is compiled once per machine.

An entry is two files, ``<key>.so`` and ``<key>.sha256``; the key is a hash of
the source, the flags, the processor and the linked solver, then one of the
compiler. Both files are written under another name and moved into place, so a
reader sees a whole file or none, and two processes that compile at once do not
disturb each other. An entry whose hash does not match is compiled again.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import os
import platform
import shlex
import shutil
import stat
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import platformdirs

from tsd_casadi.exceptions import CacheNotPrivate, CompilationFailed, CompilerNotFound

COMPILERS = ("cc", "gcc", "clang")
FLAGS = ("-O3", "-march=native", "-std=gnu11", "-fPIC", "-shared", "-fno-math-errno")


def cache_folder() -> Path:
    """The folder of compiled code, made if need be, private to the user.

    ``TSD_CACHE_DIR`` names another one.

    Raises:
        CacheNotPrivate: If somebody else could write to it.
    """
    named = os.environ.get("TSD_CACHE_DIR")
    folder = Path(named) if named else Path(platformdirs.user_cache_dir("tsd_casadi"))
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise CacheNotPrivate(folder, f"cannot be made ({error.strerror})") from error
    status = folder.stat()
    if status.st_uid != os.getuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise CacheNotPrivate(folder)
    return folder


def find_compiler() -> str:
    """Path of the C compiler: the one in CC, or the first of cc, gcc, clang.

    Raises:
        CompilerNotFound: If there is none.
    """
    candidates = tuple(shlex.split(os.environ.get("CC", ""))[:1]) or COMPILERS
    for candidate in candidates:
        path = shutil.which(candidate)
        if path is not None:
            return path
    raise CompilerNotFound(candidates)


def compile_cached(
    sources: Mapping[str, str], on_compile: Callable[[], None] | None = None
) -> Path:
    """Compile C sources into a shared library, or find it compiled already.

    Args:
        sources: Source text by file name; files ending in '.c' are compiled.
        on_compile: Called before a compilation starts, not on a cache hit.

    Returns:
        The shared library.

    Raises:
        CompilerNotFound: If it must be compiled and there is no compiler.
        CompilationFailed: If the compiler refuses.
        CacheNotPrivate: If the cache folder is not private.
    """
    folder = cache_folder()
    source_key = _source_key(sources)
    try:
        compiler_key = _compiler_key()
    except CompilerNotFound:
        # what another compiler made of the same source will do
        for library in sorted(folder.glob(f"{source_key}-*.so")):
            if _is_intact(library):
                return library
        raise
    library = folder / f"{source_key}-{compiler_key}.so"
    if _is_intact(library):
        return library
    if on_compile is not None:
        on_compile()
    with tempfile.TemporaryDirectory(dir=folder, prefix="build-") as build:
        built = _compile(sources, Path(build))
        digest = built.with_suffix(".sha256")
        digest.write_text(_digest(built))
        os.replace(built, library)
        os.replace(digest, library.with_suffix(".sha256"))
    return library


def library_key(*parts: str) -> str:
    """Name for what was compiled on this machine from some parts.

    Args:
        parts: Fingerprints of what was compiled.

    Returns:
        Hash of the parts, flags, solver, processor and compiler.
    """
    try:
        compiler = _compiler_key()
    except CompilerNotFound:
        compiler = ""
    return f"{_source_key({'parts': repr(parts)})}-{compiler}"


def verified_library(library: Path) -> Path | None:
    """A library of the cache, or None if it is not there or damaged.

    Args:
        library: Its path.
    """
    return library if _is_intact(library) else None


def _solver_folder() -> Path:
    spec = importlib.util.find_spec("casadi")  # where it is, without importing it
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("casadi", name="casadi")
    return Path(spec.origin).parent


def _source_key(sources: Mapping[str, str]) -> str:
    digest = hashlib.sha256()
    for name, text in sorted(sources.items()):
        digest.update(f"{name}\0{text}\0".encode())
    solver = (importlib.metadata.version("casadi"), str(_solver_folder()))
    digest.update(repr((FLAGS, solver, _processor())).encode())
    return digest.hexdigest()[:32]


def _compiler_key() -> str:
    command = [*_compiler_command(), "--version"]
    version = subprocess.run(command, capture_output=True, check=False).stdout
    return hashlib.sha256(repr(command).encode() + version).hexdigest()[:8]


def _compiler_command() -> list[str]:
    """The compiler with the arguments that CC may hold."""
    return [find_compiler(), *shlex.split(os.environ.get("CC", ""))[1:]]


def _processor() -> str:
    """What -march=native depends on; home folders may be shared between machines."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    described = sorted({line for line in lines if line.startswith(("flags", "Features", "model"))})
    return repr((platform.machine(), platform.processor(), described))


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _is_intact(library: Path) -> bool:
    try:
        return library.with_suffix(".sha256").read_text() == _digest(library)
    except (OSError, UnicodeDecodeError):
        return False


def _compile(sources: Mapping[str, str], build: Path) -> Path:
    for name, text in sources.items():
        (build / name).write_text(text)
    solver = _solver_folder()
    built = build / "controller.so"
    command = [
        *_compiler_command(),
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
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        raise CompilationFailed(command, run.stdout + run.stderr)
    return built
