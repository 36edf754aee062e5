from __future__ import annotations

import ctypes
import os
import resource
import shutil
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tsd_casadi.compilation import code_cache, compiler
from tsd_casadi.compilation.code_cache import cache_folder, compile_cached, keep_text
from tsd_casadi.compilation.compiler import find_compiler
from tsd_casadi.exceptions import (
    CacheNotPrivate,
    CacheNotWritable,
    CompilationFailed,
    CompilerNotFound,
    InvalidValue,
)

ANSWER = {"answer.c": '#include "answer.h"\nint answer(void) { return ANSWER; }\n'}


def sources(answer: int = 42) -> dict[str, str]:
    return {**ANSWER, "answer.h": f"#define ANSWER {answer}\n"}


def call(library: Path) -> int:
    return int(ctypes.CDLL(str(library)).answer())


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "deep" / "cache"
    monkeypatch.setenv("TSD_CACHE_DIR", str(folder))
    monkeypatch.delenv("CC", raising=False)
    return folder


@contextmanager
def no_file_beyond(size: int) -> Iterator[None]:
    """As if the disk were full: the system refuses to let any file grow further."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


class Compilations:
    def __init__(self) -> None:
        self.count = 0

    def __call__(self) -> None:
        self.count += 1


def test_a_hit_does_not_compile(folder: Path) -> None:
    compilations = Compilations()
    first = compile_cached(sources(), compilations)
    before = first.stat()
    second = compile_cached(sources(), compilations)
    assert (second, compilations.count) == (first, 1)
    assert second.stat() == before
    assert call(second) == 42
    assert first.parent == folder


def test_a_hit_runs_no_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    library = compile_cached(sources())

    def refuse(*_: object) -> Path:
        raise AssertionError("compiled again")

    monkeypatch.setattr(code_cache, "compile_library", refuse)
    assert compile_cached(sources()) == library


def test_other_sources_are_another_entry() -> None:
    libraries = [compile_cached(sources(answer)) for answer in (1, 2)]
    renamed = {"other.c": ANSWER["answer.c"], "answer.h": "#define ANSWER 1\n"}
    libraries.append(compile_cached(renamed))
    assert len(set(libraries)) == 3
    assert [call(library) for library in libraries] == [1, 2, 1]


def test_other_flags_and_other_compilers_are_another_entry(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    libraries = [compile_cached(sources())]
    for module in (code_cache, compiler):
        monkeypatch.setattr(module, "FLAGS", (*compiler.FLAGS, "-g0"))
    libraries.append(compile_cached(sources()))
    wrapper = tmp_path / "my-cc"
    wrapper.write_text(
        f'#!/bin/sh\n[ "$2" = -E ] && echo my own >&2\nexec {find_compiler()} "$@"\n'
    )
    wrapper.chmod(0o755)
    monkeypatch.setenv("CC", str(wrapper))
    libraries.append(compile_cached(sources()))
    assert len(set(libraries)) == 3


@pytest.mark.parametrize(
    "spoil",
    [
        lambda library: library.write_bytes(library.read_bytes()[:100]),
        lambda library: library.write_bytes(b""),
        lambda library: library.write_bytes(library.read_bytes() + b"x"),
        lambda library: library.unlink(),
        lambda library: library.with_suffix(".sha256").unlink(),
        lambda library: library.with_suffix(".sha256").write_bytes(b"\xff\xfe"),
        lambda library: library.with_suffix(".sha256").write_text(""),
    ],
    ids=["cut", "emptied", "grown", "gone", "no checksum", "no text", "empty checksum"],
)
def test_a_spoilt_entry_is_compiled_again(spoil: object) -> None:
    compilations = Compilations()
    library = compile_cached(sources(7), compilations)
    spoil(library)  # type: ignore[operator]
    assert compile_cached(sources(7), compilations) == library
    assert compilations.count == 2
    assert call(library) == 7
    compile_cached(sources(7), compilations)
    assert compilations.count == 2


def test_nothing_is_left_but_the_entry(folder: Path) -> None:
    library = compile_cached(sources())
    assert set(folder.iterdir()) == {library, library.with_suffix(".sha256")}
    with pytest.raises(CompilationFailed):
        compile_cached({"broken.c": "int f(void) { return; "})
    assert set(folder.iterdir()) == {library, library.with_suffix(".sha256")}


def test_two_processes_may_compile_the_same_at_once(folder: Path) -> None:
    script = """
import ctypes, sys
from tsd_casadi.compilation.code_cache import compile_cached
print("ready", flush=True)
sys.stdin.readline()
for answer in range(5):
    library = compile_cached({
        "answer.c": '#include "answer.h"\\nint answer(void) { return ANSWER; }',
        "answer.h": f"#define ANSWER {answer}",
    })
    assert ctypes.CDLL(str(library)).answer() == answer
print("done")
"""
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", script],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    for process in processes:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("\n")
        process.stdin.flush()
    for process in processes:
        out, err = process.communicate(timeout=60)
        assert (process.returncode, out, err) == (0, "done\n", "")
    assert len(list(folder.glob("*.so"))) == len(list(folder.glob("*.sha256"))) == 5
    assert not list(folder.glob("build-*"))


def test_a_new_folder_is_private(folder: Path) -> None:
    assert cache_folder() == folder
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_the_home_folder_may_be_written_as_a_tilde(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("TSD_CACHE_DIR", "~/kept")
    assert cache_folder() == tmp_path / "kept"


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777, 0o1777])
def test_a_folder_that_others_may_write_to_is_refused(folder: Path, mode: int) -> None:
    library = compile_cached(sources())
    folder.chmod(mode)
    with pytest.raises(CacheNotPrivate) as caught:
        compile_cached(sources())
    message = str(caught.value)
    assert f"chmod 700 {folder}" in message
    assert "TSD_CACHE_DIR" in message
    folder.chmod(0o755)
    assert compile_cached(sources()) == library


@pytest.mark.skipif(os.getuid() != 0, reason="only root may give a folder away")
def test_a_folder_of_another_user_is_refused(folder: Path) -> None:
    cache_folder()
    os.chown(folder, 12345, -1)
    with pytest.raises(CacheNotPrivate):
        cache_folder()


def test_a_file_in_the_folder_s_place_is_told(folder: Path) -> None:
    folder.parent.mkdir()
    folder.write_text("in the way")
    with pytest.raises(CacheNotPrivate):
        cache_folder()


def test_no_compiler_by_the_name_in_cc(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(CompilerNotFound) as caught:
        compile_cached(sources())
    assert caught.value.tried == ["no-such-compiler"]
    assert "tried no-such-compiler" in str(caught.value)


def test_no_compiler_on_the_path(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CompilerNotFound) as caught:
        compile_cached(sources())
    assert caught.value.tried == ["cc", "gcc", "clang"]
    for advice in ("apt install gcc", "dnf install gcc", "xcode-select --install", "CC"):
        assert advice in str(caught.value)


def test_gcc_is_taken_where_there_is_no_cc(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "gcc").symlink_to(find_compiler())
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find_compiler() == str(tmp_path / "gcc")


def test_a_hit_needs_no_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    library = compile_cached(sources())
    monkeypatch.setenv("PATH", str(tmp_path))
    assert compile_cached(sources()) == library


def test_cc_may_have_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", f"{shutil.which('env')} {find_compiler()}")
    assert call(compile_cached(sources())) == 42


@pytest.mark.parametrize("cc", ['gcc "', "gcc 'x", "gcc \\"])
def test_a_quote_that_is_not_closed_is_told(monkeypatch: pytest.MonkeyPatch, cc: str) -> None:
    monkeypatch.setenv("CC", cc)
    with pytest.raises(InvalidValue) as caught:
        compile_cached(sources())
    assert caught.value.field == "the variable CC"
    assert repr(cc) in str(caught.value)
    assert "a command with its arguments" in str(caught.value)


@pytest.mark.parametrize("cc", ["", " ", "''"])
def test_an_empty_cc_is_none_or_told(monkeypatch: pytest.MonkeyPatch, cc: str) -> None:
    monkeypatch.setenv("CC", cc)
    if cc.strip():
        with pytest.raises(CompilerNotFound):
            compile_cached(sources())
    else:
        assert call(compile_cached(sources())) == 42


def test_a_compiler_that_is_no_program_is_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    text = tmp_path / "text"
    text.write_bytes(b"\x7fnot a program")
    text.chmod(0o755)
    monkeypatch.setenv("CC", str(text))
    with pytest.raises(CompilationFailed, match="Exec format error") as caught:
        compile_cached(sources())
    assert caught.value.command is not None
    assert caught.value.command[0] == str(text)


def test_a_compiler_that_makes_nothing_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", str(shutil.which("true")))
    with pytest.raises(CompilationFailed):
        compile_cached(sources())


def test_a_compiler_that_prints_no_text_is_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    wrapper = tmp_path / "latin-cc"
    wrapper.write_text("#!/bin/sh\nprintf 'unzul\\344ssig\\n'; exit 1\n")
    wrapper.chmod(0o755)
    monkeypatch.setenv("CC", str(wrapper))
    with pytest.raises(CompilationFailed, match=r"unzul.ssig"):
        compile_cached(sources())


def test_no_room_for_what_was_compiled_is_told(folder: Path) -> None:
    cache_folder()
    with no_file_beyond(8), pytest.raises(CacheNotWritable) as caught:
        compile_cached(sources())
    assert caught.value.path == folder
    assert "TSD_CACHE_DIR" in str(caught.value)
    with no_file_beyond(8), pytest.raises(CacheNotWritable):
        keep_text(folder / "index.json", "much longer")
    assert list(folder.iterdir()) == []


def test_a_refusing_compiler_is_quoted(folder: Path) -> None:
    with pytest.raises(CompilationFailed) as caught:
        compile_cached({"broken.c": "int f(void) { return undeclared_name; }\n"})
    message = str(caught.value)
    assert "undeclared_name" in message
    assert find_compiler() in message
    assert "CC" in message
    assert caught.value.command[0] == find_compiler()
    assert "undeclared_name" in caught.value.output
    assert not list(folder.glob("*.so"))


def test_a_failing_compiler_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", str(shutil.which("false")))
    with pytest.raises(CompilationFailed):
        compile_cached(sources())


def test_a_compiler_that_was_killed_halfway_leaves_no_entry(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, folder: Path
) -> None:
    wrapper = tmp_path / "dying-cc"
    wrapper.write_text(f'#!/bin/sh\n{find_compiler()} "$@"\nexit 1\n')
    wrapper.chmod(0o755)
    monkeypatch.setenv("CC", str(wrapper))
    with pytest.raises(CompilationFailed):
        compile_cached(sources())
    assert list(folder.iterdir()) == []
