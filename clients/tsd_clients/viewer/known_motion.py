"""What a learner knows of one motion, as far as it can be generalised together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from tsd_casadi.learning.context import Context
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.motions.parameter import Parameter
from tsd_casadi.wire.learner import EntryMessage
from tsd_clients.viewer.parameter_slider import ParameterSlider

# entries are told apart by parameters rounded to that
DIGITS = 6


@dataclass(frozen=True)
class KnownMotion:
    """Entries of one robot, motion, version, axes and context.

    Attributes:
        robot: Name of the robot.
        motion: Name of the motion.
        version: Of the motion.
        axes: That were learned.
        context: What was the same for all.
        entries: Those that learned something, in the order of their numbers.
    """

    robot: str
    motion: str
    version: str
    axes: tuple[str, ...]
    context: Context
    entries: tuple[EntryMessage, ...]

    @property
    def name(self) -> str:
        """Robot and motion, for people."""
        return f"{self.robot}: {self.motion}"

    @property
    def group(self) -> str:
        """What tells it from others of the same name, for people."""
        body = self.context.body[:6] or "unknown"
        correction = f", corrected {self.context.correction[:6]}" if self.context.correction else ""
        number = len(self.entries)
        count = f"{number} entries" if number > 1 else "1 entry"
        version = f", version {self.version}" if self.version else ""
        formulation = f" {self.context.formulation[:6]}" if self.context.formulation else ""
        return f"{', '.join(self.axes)} ({count}, body {body}{formulation}{correction}{version})"

    def sliders(self, declaration: Declaration | None = None) -> tuple[ParameterSlider, ...]:
        """Make a slider for each parameter, those first in which entries differ.

        Args:
            declaration: What is said of the motion, if that is known: ranges and meanings.
        """
        said = {} if declaration is None else {each.name: each for each in declaration.parameters}
        found = [
            ParameterSlider.over(
                said.get(name, Parameter(name, quantity.unit)),
                [entry.parameters[name].value for entry in self.entries],
            )
            for name, quantity in self.entries[0].parameters.items()
        ]
        return tuple(sorted(found, key=lambda each: not each.varies))

    def at(self, parameters: Mapping[str, float]) -> EntryMessage | None:
        """Find the entry of exactly these parameters."""
        wanted = {name: round(value, DIGITS) for name, value in parameters.items()}
        return next((each for each in self.entries if parameters_of(each) == wanted), None)

    def nearest(self, parameters: Mapping[str, float], most: int) -> list[EntryMessage]:
        """List the entries around some parameters, the nearest first.

        Each parameter counts by the share of what the entries span.
        """
        names = list(self.entries[0].parameters)
        places = np.array(
            [[each.parameters[name].value for name in names] for each in self.entries]
        )
        span = np.ptp(places, axis=0)
        span[span == 0] = 1.0  # the same for all: changes no order
        offsets = (places - [parameters[name] for name in names]) / span
        order = np.argsort(np.linalg.norm(offsets, axis=1), kind="stable")
        return [self.entries[index] for index in order[:most].tolist()]


def known_motions(entries: Iterable[EntryMessage]) -> list[KnownMotion]:
    """Sort entries that learned something by what can be generalised together.

    Returns:
        What was learned last first.
    """
    groups: dict[tuple[object, ...], list[EntryMessage]] = {}
    for entry in entries:
        if entry.served == 0:
            continue  # nothing was learned there yet
        axes = tuple(axis.name for axis in entry.axes)
        context = tuple(entry.context.model_dump().values())
        key = entry.robot, entry.motion, entry.version, axes, context, frozenset(entry.parameters)
        groups.setdefault(key, []).append(entry)
    newest = sorted(groups.values(), key=lambda each: max(e.updated for e in each), reverse=True)
    return [_known(sorted(each, key=lambda entry: entry.entry)) for each in newest]


def _known(entries: list[EntryMessage]) -> KnownMotion:
    first = entries[0]
    return KnownMotion(
        robot=first.robot,
        motion=first.motion,
        version=first.version,
        axes=tuple(axis.name for axis in first.axes),
        context=first.context.context(),
        entries=tuple(entries),
    )


def parameters_of(entry: EntryMessage) -> dict[str, float]:
    """Tell the parameters of an entry, SI units."""
    return {name: each.value for name, each in entry.parameters.items()}


def place_of(entry: EntryMessage) -> str:
    """Tell where an entry is, for people: 'amplitude 0.04 m, frequency 0.25 Hz'."""
    return ", ".join(
        f"{name} {each.value:g} {'' if each.unit == '1' else each.unit}".rstrip()
        for name, each in entry.parameters.items()
    )
