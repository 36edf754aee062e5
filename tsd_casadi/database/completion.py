"""A recording against what is said of its motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tsd_casadi.database.answering import declaration_of
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.recording import Recording


def complete(recording: Recording, entries: Sequence[Entry]) -> Recording:
    """Check the parameters of a recording, and fill in those with a default.

    Args:
        entries: Of the motion on the same robot: what was said last counts where
            the recording says nothing.

    Raises:
        InvalidValue: If the declaration is of another motion, or a parameter is
            missing or makes no sense.
    """
    key = recording.key
    declaration = recording.declaration or declaration_of(key.motion, key.version, entries)
    if (declaration.motion, declaration.version) != (key.motion, key.version):
        raise InvalidValue(
            "declaration",
            f"of {declaration.motion}, version {declaration.version}",
            f"that of {key.motion}, version {key.version}",
        )
    parameters = declaration.complete(dict(key.parameters))
    whole = EntryKey.of(key.robot, key.motion, key.version, key.axes, parameters, key.context)
    return replace(recording, key=whole)
