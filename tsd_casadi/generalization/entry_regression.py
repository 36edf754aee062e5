"""Feedforward for parameters that were never tried, from the entries that were."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import asdict

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import EntryNotFound
from tsd_casadi.generalization.weight_regression import WeightRegression
from tsd_casadi.learning.axis_error import plain_errors
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.declaration import Declaration

MINIMUM_ENTRIES = 2
# all of them are read and compared; beyond, a service would be at risk
MOST_ENTRIES = 1_000
# entries that an error names, the others are counted
MOST_TOLD = 10
# fits that are kept, one per group of entries
KEPT_FITS = 32

_Content = tuple[Declaration, tuple[str, ...], PeriodicBasis, bytes, bytes, tuple[bytes, ...]]


class EntryRegressions:
    """Regressions over entries, fitted again only when the entries changed."""

    def __init__(self) -> None:
        """Start with nothing fitted."""
        self._fits: dict[_Content, WeightRegression] = {}

    def generalize(
        self,
        declaration: Declaration,
        entries: Sequence[Entry],
        wanted: dict[str, float],
        extrapolate: bool,
    ) -> Feedforward:
        """Predict weights for the wanted parameters from all entries but the exact one.

        Args:
            declaration: What is said of the motion.
            entries: Entries of it on one robot, of one context and one set of axes.
            wanted: All parameters of the motion, SI units.
            extrapolate: Answer outside the learned range too.

        Returns:
            The feedforward, with the entries used as its provenance, and those
            that were left out since the others contradict them.

        Raises:
            EntryNotFound: If there are too few entries, they do not fit
                together, or all of them have a parameter that is not the wanted.
            OutsideTrainedRange: If it would be an extrapolation.
        """
        motion = declaration.motion
        others = [
            entry
            for entry in entries
            if is_learned(entry, wanted) and dict(entry.key.parameters) != wanted
        ]
        if len(others) < MINIMUM_ENTRIES:
            raise EntryNotFound(
                f"generalising for {describe_motion(motion, wanted.items())} needs at least "
                f"{MINIMUM_ENTRIES} learned entries beside that one; there is "
                f"{_described(entries)}. Learn more of them"
            )
        regression = self.over(declaration, others)
        for name, value in wanted.items():
            learned = dict(others[0].key.parameters)[name]
            if name not in regression.names and learned != value:
                unit = declaration.unit_of(name)
                raise EntryNotFound(
                    f"every learned {motion} has {name} {learned:g} {unit}, none can be "
                    f"generalised to {value:g} {unit}; learn some at other values of {name}"
                )
        weights, deviations = regression.predict(wanted, extrapolate=extrapolate)
        used = [each for i, each in enumerate(others) if i not in regression.disagreeing]
        served = [entry.served for entry in used]
        provenance = {
            "entries": [entry.identifier for entry in used],
            "disagreeing": [
                {
                    "entry": others[index].identifier,
                    "parameters": dict(others[index].key.parameters),
                    "deviations": round(off, 1),
                }
                for index, off in sorted(regression.disagreeing.items())
            ],
            "parameters": [dict(entry.key.parameters) for entry in used],
            "iterations": [iteration.number for iteration in served],
            "iteration": min(iteration.number for iteration in served),
            "errors": [
                None if iteration.errors is None else plain_errors(iteration.errors)
                for iteration in served
            ],
            "gains": [entry.circumstances.gains for entry in used],
            "hardware": [entry.circumstances.hardware for entry in used],
            "kernels": dict(zip(others[0].key.axes, regression.kernels, strict=True)),
            "length_scales": regression.length_scales,
            "calibration": regression.calibration,
            "axes": list(others[0].key.axes),
            "context": asdict(others[0].key.context),
        }
        return Feedforward(
            axes=others[0].key.axes,
            basis=others[0].basis,
            weights=weights,
            standard_deviations=deviations,
            kind="generalised",
            parameters=wanted,
            provenance=provenance,
            declaration=declaration,
            bands=regression.bands(deviations),
        )

    def over(self, declaration: Declaration, entries: Sequence[Entry]) -> WeightRegression:
        """Fit over all parameters in which some entries differ, unless that was done.

        Args:
            entries: Learned entries with the same names of parameters.

        Raises:
            EntryNotFound: If they are too few or do not fit together.
        """
        _check_same_basis(entries)
        parameters = [dict(entry.key.parameters) for entry in entries]
        names = varied_parameters(entries)
        inputs = np.array([[each[name] for name in names] for each in parameters])
        weights = [entry.served.weights for entry in entries]
        uncertainties = [entry.served.uncertainty for entry in entries]
        basis = entries[0].basis
        content = (
            declaration,
            names,
            basis,
            inputs.tobytes(),
            np.stack(weights).tobytes(),
            tuple(b"" if each is None else each.tobytes() for each in uncertainties),
        )
        if content not in self._fits:
            regression = WeightRegression(declaration, names, inputs, weights, basis, uncertainties)
            if len(self._fits) >= KEPT_FITS:
                self._fits.pop(next(iter(self._fits)))  # the oldest
            self._fits[content] = regression
        return self._fits[content]


def is_learned(entry: Entry, names: Collection[str]) -> bool:
    """Say whether an entry has these parameters and no others, and learned something."""
    return dict(entry.key.parameters).keys() == set(names) and entry.served.number > 0


def varied_parameters(entries: Sequence[Entry]) -> tuple[str, ...]:
    """Name the parameters in which some entries differ.

    Args:
        entries: Entries with the same names of parameters.
    """
    columns: dict[str, set[float]] = {}
    for entry in entries:
        for name, value in entry.key.parameters:
            columns.setdefault(name, set()).add(value)
    return tuple(name for name, values in columns.items() if len(values) > 1)


def _check_same_basis(entries: Sequence[Entry]) -> None:
    kinds = {(entry.basis, entry.key.axes, entry.key.context) for entry in entries}
    if len(kinds) > 1:
        raise EntryNotFound(
            f"the entries {_described(entries)} were learned with different bases, axes "
            "or contexts and cannot be generalised together; forget or restart some"
        )


def describe_motion(motion: str, parameters: Iterable[tuple[str, float]]) -> str:
    """Tell people: 'squat amplitude=0.03 frequency=0.25'."""
    return " ".join([motion, *(f"{name}={value:g}" for name, value in parameters)])


def describe_entries(
    keys: Sequence[EntryKey], size: int, axes: Collection[str] | None = None
) -> str:
    """Tell people the motions of some entries.

    Args:
        size: Number of all of them.
        axes: That were asked for: an entry with others beside them does not serve, and says so.
    """
    told = []
    for key in keys[:MOST_TOLD]:
        beside = axes is not None and not set(key.axes) <= set(axes)
        along = f" along {', '.join(key.axes)}" if beside else ""
        told.append(describe_motion(key.motion, key.parameters) + along)
    listed = ", ".join(told) or "nothing yet"
    return f"{listed} and {size - len(told)} more" if size > len(told) else listed


def _described(entries: Sequence[Entry]) -> str:
    return describe_entries([entry.key for entry in entries], len(entries))
