"""The motions there are: those of this folder, and those in users' own files."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from functools import cache
from pathlib import Path

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.exceptions.did_you_mean import did_you_mean
from tsd_casadi.motions.file import motion_of_file
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.own_motion import load_own

FOLDER = Path(__file__).parent
PACKAGE = __name__.rpartition(".")[0]

# of files with references instead of a class
DATA = (".csv", ".npz")


@cache
def shipped_motions() -> dict[str, type[Motion]]:
    """Find the motions that come with the project, by name: every class of this folder."""
    found: dict[str, type[Motion]] = {}
    for module in pkgutil.iter_modules([str(FOLDER)]):
        members = vars(importlib.import_module(f"{PACKAGE}.{module.name}")).values()
        for member in members:
            if inspect.isclass(member) and issubclass(member, Motion) and "name" in vars(member):
                found[member.name] = member
    return dict(sorted(found.items()))


def find_motion(name: str) -> type[Motion]:
    """Find a motion's class.

    Args:
        name: Of a shipped motion; or a class in a file, 'my_motion.py:Bounce'; or a
            file with references, 'wave.csv' or 'wave.npz'.

    Raises:
        InvalidValue: If there is none, or it is not one that can be learned; it
            says what is missing.
    """
    place, colon, member = name.rpartition(":")
    if colon and place.endswith(".py"):
        return load_own(Path(place), member, shipped_motions())
    if name.endswith(".py"):
        raise InvalidValue("motion", f"'{name}'", f"the class as well, as {name}:Bounce")
    if Path(name).suffix.lower() in DATA:
        return motion_of_file(Path(name))
    known = shipped_motions()
    if name not in known:
        listed = ", ".join(f"'{each}'" for each in known)
        raise InvalidValue(
            "motion",
            f"'{name}'",
            f"one of {listed}, or a file: my_motion.py:Bounce, wave.csv{did_you_mean(name, known)}",
        )
    return known[name]
