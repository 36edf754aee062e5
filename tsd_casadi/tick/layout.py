"""Named fields in one flat vector of float64.

A tick's request and reply are such vectors: in process, in the compiled code
and on the wire. One layout, made here, describes all three.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from tsd_casadi.exceptions import UnknownField
from tsd_casadi.state import Vector

HUGE = 1e9
# A float32 quaternion is a unit quaternion to 1e-7.
QUATERNION_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Field:
    """One named slice of a vector.

    Attributes:
        name: Dotted name, for instance 'com.P'.
        size: Number of float64.
        unit: SI unit.
        description: Meaning, with frame.
        lower: Smallest accepted value.
        upper: Largest accepted value.
        default: Values at the home posture, shape (size,).
        unit_quaternion: Index in the field where a unit quaternion xyzw
            starts, or None.
        switch: Whether only 0 and 1 are accepted.
    """

    name: str
    size: int
    unit: str
    description: str
    lower: float = -HUGE
    upper: float = HUGE
    default: tuple[float, ...] = ()
    unit_quaternion: int | None = None
    switch: bool = False


@dataclass(frozen=True)
class Layout:
    """The fields of a vector, in order.

    Attributes:
        fields: The fields.
        slices: Where each one lies, by name.
        size: Size of the vector.
    """

    fields: tuple[Field, ...]
    slices: dict[str, slice] = field(init=False)
    size: int = field(init=False)

    def __post_init__(self) -> None:
        """Place the fields one behind the other."""
        slices: dict[str, slice] = {}
        offset = 0
        for part in self.fields:
            slices[part.name] = slice(offset, offset + part.size)
            offset += part.size
        object.__setattr__(self, "slices", slices)
        object.__setattr__(self, "size", offset)

    def __iter__(self) -> Iterator[Field]:
        """Iterate over the fields."""
        return iter(self.fields)

    def slice(self, name: str) -> slice:
        """Tell where a field lies.

        Returns:
            Its slice.

        Raises:
            UnknownField: If there is none of that name.
        """
        try:
            return self.slices[name]
        except KeyError:
            raise UnknownField(name, list(self.slices)) from None

    def locate(self, index: int) -> tuple[Field, int]:
        """Tell which field a position in the vector belongs to.

        Returns:
            The field and the index inside it.
        """
        for part in self.fields:
            place = self.slices[part.name]
            if place.start <= index < place.stop:
                return part, index - place.start
        raise IndexError(index)

    def defaults(self) -> Vector:
        """Put the defaults of all fields together, shape (size,)."""
        return np.concatenate([np.asarray(part.default, dtype=float) for part in self.fields])

    def lower(self) -> Vector:
        """Put the smallest accepted values together, shape (size,)."""
        return np.concatenate([np.full(part.size, part.lower) for part in self.fields])

    def upper(self) -> Vector:
        """Put the largest accepted values together, shape (size,)."""
        return np.concatenate([np.full(part.size, part.upper) for part in self.fields])

    def quaternions(self) -> list[int]:
        """List the positions at which unit quaternions start."""
        return [
            self.slices[part.name].start + part.unit_quaternion
            for part in self.fields
            if part.unit_quaternion is not None
        ]

    def switches(self) -> list[int]:
        """List the positions that accept only 0 and 1."""
        return [
            index
            for part in self.fields
            if part.switch
            for index in range(self.slices[part.name].start, self.slices[part.name].stop)
        ]


def hash_layouts(layouts: Sequence[Layout]) -> int:
    """Hash what the vectors of one protocol mean: names, sizes and units.

    Returns:
        64-bit unsigned integer.
    """
    meaning = [[(part.name, part.size, part.unit) for part in layout] for layout in layouts]
    digest = hashlib.sha256(json.dumps(meaning).encode()).digest()
    return int.from_bytes(digest[:8], "little")
