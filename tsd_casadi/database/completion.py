"""A recording against what is said of its motion."""

from __future__ import annotations

from dataclasses import replace

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.recording import Recording
from tsd_casadi.motions.declaration import Declaration


def complete(recording: Recording, said: Declaration) -> Recording:
    """Check the parameters of a recording, and fill in those with a default.

    Args:
        said: What was said last of the motion, on the same robot; it counts where the
            recording says nothing.

    Raises:
        InvalidValue: If the declaration is of another motion, or a parameter is
            missing or makes no sense.
    """
    key = recording.key
    declaration = recording.declaration or said
    if (declaration.motion, declaration.version) != (key.motion, key.version):
        raise InvalidValue(
            "declaration",
            f"of {declaration.motion}, version {declaration.version}",
            f"that of {key.motion}, version {key.version}",
        )
    parameters = declaration.complete(dict(key.parameters))
    whole = EntryKey.of(key.robot, key.motion, key.version, key.axes, parameters, key.context)
    return replace(recording, key=whole)
