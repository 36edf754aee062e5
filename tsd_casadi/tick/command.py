"""What a controller is asked to do at one tick."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.layout import Field, Layout


class Command:
    """References, gains, weights and limits, with room for the state.

    Fields are read and set by name::

        command["com.P"] = 10.0
        command["com.reference"][2] += 0.01

    Attributes:
        request: The whole request vector, (layout.size,); q and v are written
            at each tick.
    """

    def __init__(self, layout: Layout) -> None:
        """Start from the defaults of a request's layout: hold the home posture."""
        self._layout = layout
        self._q = layout.slice("q")
        self._v = layout.slice("v")
        self.request = layout.defaults()

    def __repr__(self) -> str:
        """Say how much can be set."""
        return f"<Command: {self.request.size} float64 in {len(self.fields)} fields, see .fields>"

    @property
    def fields(self) -> dict[str, Field]:
        """What can be set, by name, with size, unit, meaning and range."""
        return {field.name: field for field in self._layout}

    def __getitem__(self, name: str) -> Vector:
        """Give a writable view of a field.

        Raises:
            UnknownField: If there is none of that name.
        """
        return self.request[self._layout.slice(name)]

    def __setitem__(self, name: str, value: ArrayLike) -> None:
        """Set a field; one number fills all of it.

        Raises:
            UnknownField: If there is none of that name.
            InvalidValue: If the shape does not fit.
        """
        place = self._layout.slice(name)
        array = np.asarray(value, dtype=float)
        size = place.stop - place.start
        if array.shape not in ((), (1,), (size,)):
            raise InvalidValue(name, f"of shape {array.shape}", f"one number or shape ({size},)")
        self.request[place] = array

    def set_state(self, state: State) -> None:
        """Write the state into the request.

        Args:
            state: q and v in Pinocchio's conventions.

        Raises:
            InvalidValue: If q or v has another size.
        """
        for name, value, place in (("q", state.q, self._q), ("v", state.v, self._v)):
            if np.shape(value) != (place.stop - place.start,):
                size = place.stop - place.start
                raise InvalidValue(name, f"of shape {np.shape(value)}", f"shape ({size},)")
        self.request[self._q] = state.q
        self.request[self._v] = state.v

    def copy(self) -> Command:
        """Make an independent copy."""
        other = Command(self._layout)
        other.request[:] = self.request
        return other
