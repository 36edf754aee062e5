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
import os
import platform
import stat
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import platformdirs

from tsd_casadi.compilation.compiler import FLAGS, compile_library, compiler_key, solver_folder
from tsd_casadi.compilation.held_signals import held_signals
from tsd_casadi.exceptions import CacheNotPrivate, CacheNotWritable, CompilerNotFound


def cache_folder() -> Path:
    """Find the folder of compiled code, private to the user, and make it if need be.

    ``TSD_CACHE_DIR`` names another one.

    Raises:
        CacheNotPrivate: If somebody else could write to it.
    """
    named = os.environ.get("TSD_CACHE_DIR") or platformdirs.user_cache_dir("tsd_casadi")
    folder = Path(os.path.expanduser(named))
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise CacheNotPrivate(folder, f"cannot be made ({error.strerror})") from error
    status = folder.stat()
    if status.st_uid != os.getuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise CacheNotPrivate(folder)
    return folder


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
        CacheNotWritable: If what was compiled cannot be kept.
        InvalidValue: If the variable CC is no command.
    """
    folder = cache_folder()
    source_key = _source_key(sources)
    try:
        compiler = compiler_key()
    except CompilerNotFound:
        # what another compiler made of the same source will do
        for library in sorted(folder.glob(f"{source_key}-*.so")):
            if _is_intact(library):
                return library
        raise
    library = folder / f"{source_key}-{compiler}.so"
    if _is_intact(library):
        return library
    if on_compile is not None:
        on_compile()
    with held_signals() as came, _build_folder(folder) as build:
        built = compile_library(sources, build, came)
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
        compiler = compiler_key()
    except CompilerNotFound:
        compiler = ""
    return f"{_source_key({'parts': repr(parts)})}-{compiler}"


def keep_text(path: Path, text: str) -> None:
    """Write a file of the cache, whole or not at all.

    Raises:
        CacheNotWritable: If it cannot be written.
    """
    with held_signals(), _build_folder(path.parent) as build:
        written = build / path.name
        written.write_text(text)
        os.replace(written, path)


def verified_library(library: Path) -> Path | None:
    """Find a library of the cache; None if it is not there or damaged."""
    return library if _is_intact(library) else None


@contextmanager
def _build_folder(folder: Path) -> Iterator[Path]:
    """Make a folder in the cache that is gone afterwards."""
    try:
        with tempfile.TemporaryDirectory(dir=folder, prefix="build-") as build:
            yield Path(build)
    except OSError as error:
        raise CacheNotWritable(folder, error.strerror or str(error)) from error


def _source_key(sources: Mapping[str, str]) -> str:
    digest = hashlib.sha256()
    for name, text in sorted(sources.items()):
        digest.update(f"{name}\0{text}\0".encode())
    solver = (importlib.metadata.version("casadi"), str(solver_folder()))
    digest.update(repr((FLAGS, solver, _processor())).encode())
    return digest.hexdigest()[:32]


def _processor() -> str:
    """Tell what -march=native depends on; home folders may be shared between machines."""
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
