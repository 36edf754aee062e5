"""Feedforward for task parameters that were never tried, from the entries that were."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from tsd_casadi.entry import Entry
from tsd_casadi.exceptions import EntryNotFound
from tsd_casadi.feedforward import Feedforward
from tsd_casadi.generalization import WeightRegression
from tsd_casadi.motions.squat import UNITS

# the parameter that is regressed over; the others must be equal
PARAMETER = "amplitude"
# fits that are kept, one per group of entries with the same other parameters
KEPT_FITS = 32

_Content = tuple[tuple[float, ...], bytes]


class EntryRegressions:
    """Regressions over entries, fitted again only when the entries changed."""

    def __init__(self) -> None:
        """Start with nothing fitted."""
        self._fits: dict[_Content, WeightRegression] = {}

    def generalise(
        self, task: str, entries: Sequence[Entry], wanted: dict[str, float], extrapolate: bool
    ) -> Feedforward:
        """Weights for the wanted parameters from all entries but the exact one.

        Args:
            task: Name of the motion, for errors.
            entries: Entries of the task on one robot.
            wanted: Task parameters, SI units.
            extrapolate: Answer outside the learned range too.

        Returns:
            The feedforward, with the entries used as its provenance.

        Raises:
            EntryNotFound: If there are too few entries, or they do not fit
                together.
            OutsideTrainedRange: If it would be an extrapolation.
        """
        others = [entry for entry in entries if _is_beside(entry, wanted)]
        if not others:
            raise EntryNotFound(
                f"nothing to generalise from for {describe_task(task, wanted.items())}; "
                f"there is {describe_entries(entries)}. Learn other amplitudes at this frequency"
            )
        _check_same_basis(others)
        inputs = [_parameter(entry) for entry in others]
        served = [entry.served for entry in others]
        regression = self._fit(inputs, others)
        weights, deviations = regression.predict(wanted[PARAMETER], extrapolate=extrapolate)
        provenance = {
            "entries": [entry.identifier for entry in others],
            "amplitudes": inputs,
            "iterations": [iteration.number for iteration in served],
            "iteration": min(iteration.number for iteration in served),
            "errors": [iteration.errors for iteration in served],
            "gains": [entry.context.gains for entry in others],
            "kernel": regression.kernel,
            "formulation": others[0].context.formulation,
        }
        return Feedforward(
            axes=others[0].key.axes,
            basis=others[0].basis,
            weights=weights,
            standard_deviations=deviations,
            kind="generalised",
            parameters=wanted,
            provenance=provenance,
        )

    def _fit(self, inputs: list[float], entries: list[Entry]) -> WeightRegression:
        weights = [entry.served.weights for entry in entries]
        content = tuple(inputs), b"".join(matrix.tobytes() for matrix in weights)
        if content not in self._fits:
            if len(self._fits) >= KEPT_FITS:
                self._fits.pop(next(iter(self._fits)))  # the oldest
            self._fits[content] = WeightRegression(PARAMETER, UNITS[PARAMETER], inputs, weights)
        return self._fits[content]


def _parameter(entry: Entry) -> float:
    return dict(entry.key.parameters)[PARAMETER]


def _is_beside(entry: Entry, wanted: dict[str, float]) -> bool:
    """Learned, at another amplitude and otherwise equal parameters."""
    parameters = dict(entry.key.parameters)
    equal_otherwise = {**parameters, PARAMETER: wanted[PARAMETER]} == wanted
    return equal_otherwise and parameters != wanted and entry.served.number > 0


def _check_same_basis(entries: list[Entry]) -> None:
    kinds = {(entry.basis, entry.key.axes, entry.context.formulation) for entry in entries}
    if len(kinds) > 1:
        raise EntryNotFound(
            f"the entries {describe_entries(entries)} were learned with different bases, axes "
            "or formulations and cannot be generalised together; forget or restart some"
        )


def describe_task(task: str, parameters: Iterable[tuple[str, float]]) -> str:
    """For people: 'squat amplitude=0.03 frequency=0.25'."""
    return " ".join([task, *(f"{name}={value:g}" for name, value in parameters)])


def describe_entries(entries: Iterable[Entry]) -> str:
    """For people: the tasks of some entries."""
    listed = [describe_task(entry.key.task, entry.key.parameters) for entry in entries]
    return ", ".join(listed) or "nothing yet"
