"""A motion from a file of somebody's own: loaded, and checked before a robot moves."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Container
from pathlib import Path
from typing import Any

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.exceptions.did_you_mean import did_you_mean
from tsd_casadi.motions.check_kind import check_kind
from tsd_casadi.motions.motion import Motion


def load_own(path: Path, name: str, taken: Container[str] = ()) -> type[Motion]:
    """Load a motion's class from a file and check it.

    Its version is the file's content: an edited file is another motion.

    Args:
        path: The file (.py), run as any module is when it is imported.
        name: Of the class.
        taken: Names that the motion may not have.

    Raises:
        InvalidValue: If there is no such file or class, the file does not run, or
            the class is no motion.
    """
    path = path.expanduser()
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InvalidValue(
            "motion", f"'{path}', which cannot be read ({error.strerror})", "a file of Python"
        ) from None
    version = hashlib.sha256(content).hexdigest()[:12]
    module = _run(path, f"tsd_motion_{version}")
    kinds = [
        key
        for key, value in vars(module).items()
        if inspect.isclass(value) and issubclass(value, Motion) and value is not Motion
    ]
    kind = getattr(module, name, None)
    if name not in kinds or kind is None:
        found = f"'{name}'" if kind is None else f"'{name}', which is no subclass of Motion"
        listed = ", ".join(kinds) or "a subclass of tsd_casadi.motions.motion.Motion"
        raise InvalidValue(f"class in {path}", found, f"{listed}{did_you_mean(name, kinds)}")
    found_kind: type[Motion] = kind
    check_kind(found_kind)
    if found_kind.name in taken:
        raise InvalidValue(
            f"name of {name}", f"'{found_kind.name}', which is shipped", "a name of its own"
        )
    found_kind.version = version
    return found_kind


def _run(path: Path, name: str) -> Any:
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None  # it ends in .py
    module = importlib.util.module_from_spec(spec)
    # dataclasses look for their module there
    sys.modules[name] = module
    # what lies beside it may be imported, as when it is run
    beside = str(path.resolve().parent)
    sys.path.insert(0, beside)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        line = getattr(error, "lineno", None)
        if line is None:
            trace = error.__traceback__
            while trace is not None:
                if trace.tb_frame.f_code.co_filename == str(path):
                    line = trace.tb_lineno
                trace = trace.tb_next
        where = f" in line {line}" if line else ""
        raise InvalidValue(
            "motion", f"'{path}', which raises {type(error).__name__}{where}: {error}", "no error"
        ) from error
    finally:
        sys.path.remove(beside)
    return module
