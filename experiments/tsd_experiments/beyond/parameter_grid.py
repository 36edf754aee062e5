"""Generalisation over amplitude and frequency on the stand-in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from tsd_casadi.encoding.harmonics import sample_phases
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.generalization.weight_regression import NOISE, WeightRegression
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.state import Matrix, Vector
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.experiment import (
    Done,
    Experiment,
    Figure,
    Goal,
    Section,
    Table,
    millimetres,
)
from tsd_experiments.harness.jobs import Job
from tsd_experiments.harness.work import learn, replay
from tsd_experiments.report.drawing import draw_bands

Point = tuple[float, float]  # amplitude [m], frequency [Hz]

NAMES = ("amplitude", "frequency")
# corners, middles of the edges, and the middles of the quarters
LEARNED: tuple[Point, ...] = (
    (0.03, 0.2),
    (0.03, 0.6),
    (0.08, 0.2),
    (0.08, 0.6),
    (0.055, 0.2),
    (0.055, 0.6),
    (0.03, 0.4),
    (0.08, 0.4),
    (0.0425, 0.3),
    (0.0425, 0.5),
    (0.0675, 0.3),
    (0.0675, 0.5),
)
HELD_OUT: tuple[Point, ...] = tuple(
    (amplitude, frequency)
    for amplitude in (0.036, 0.044, 0.05, 0.058, 0.066, 0.076)
    for frequency in (0.22, 0.26, 0.31, 0.37, 0.45, 0.52)
)
# of them those where predictions are driven as well: black fields of the board
DRIVEN = tuple(point for i, point in enumerate(HELD_OUT) if (i + i // 6) % 2 == 0)
# learned once more with other sensor noise
REPEATED: tuple[Point, ...] = ((0.03, 0.2), (0.0425, 0.3), (0.0675, 0.5), (0.08, 0.6))
OTHER_SEED = 1
CORNERS = LEARNED[:4]
# slow and small, in the middle, fast and large
SHOWN = (HELD_OUT[0], HELD_OUT[15], HELD_OUT[-1])
DRAWS = 20
ITERATIONS = 5
SOURCES = ("generalised", "linear")


class ParameterGrid(Experiment):
    """12 learned entries, 36 held out."""

    name = "grid"
    case = Case(hardware=("all",))

    def jobs(self, done: Done) -> list[Job]:
        """Entries first, then runs with their predictions; nothing in the short form."""
        if self.quick:
            return []
        entries = [self._entry(point) for point in (*LEARNED, *HELD_OUT)]
        entries += [self._entry(point, OTHER_SEED) for point in REPEATED]
        if any(job.name not in done for job in entries):
            return entries
        regression, linear = self._regression(done, LEARNED), self._interpolation(done)
        jobs = []
        for point in DRIVEN:
            predictions = {
                "generalised": regression.predict(dict(zip(NAMES, point, strict=True)))[0][0],
                "linear": linear([point])[0],
            }
            for source, weights in predictions.items():
                arguments = {
                    "case": self._case(point).plain(),
                    "weights": [float(value) for value in weights],
                    "kind": "generalised",
                }
                name = f"grid-{source}-{_label(point)}"
                jobs.append(Job(name, replay, arguments, cost=4))
        return entries + jobs

    def _case(self, point: Point) -> Case:
        return replace(self.case, amplitude=point[0], frequency=point[1])

    def _entry(self, point: Point, seed: int = 0) -> Job:
        arguments = {
            "case": replace(self._case(point), seed=seed).plain(),
            "rule": "stable",
            "iterations": ITERATIONS,
        }
        cost = (1 + 3.5 / point[1]) * (ITERATIONS + 1) / 3
        kind = "again" if seed else "entry"
        return Job(f"grid-{kind}-{_label(point)}", learn, arguments, cost=cost)

    def _weights(self, done: Done, point: Point, seed: int = 0) -> Matrix:
        result = done[self._entry(point, seed).name]
        return np.array([result.weights(result.last_iteration())])

    def _regression(self, done: Done, points: Sequence[Point]) -> WeightRegression:
        weights = [self._weights(done, point) for point in points]
        basis = PeriodicBasis.of_size(weights[0].shape[1])
        return WeightRegression("squat", NAMES, np.array(points), weights, basis)

    def _interpolation(self, done: Done) -> Any:
        weights = [self._weights(done, point)[0] for point in LEARNED]
        return LinearNDInterpolator(np.array(LEARNED), np.array(weights), rescale=True)

    def coverage(self, done: Done, points: Sequence[Point]) -> list[float]:
        """Share of each other curve within two predicted standard deviations.

        Args:
            done: Finished jobs by name.
            points: The entries to predict from.
        """
        regression = self._regression(done, points)
        return [
            float(np.mean(np.abs(curve - mean) <= 2 * std))
            for mean, std, curve in (
                self._prediction(regression, done, point)
                for point in (*LEARNED, *HELD_OUT)
                if point not in points
            )
        ]

    def coverage_of_draws(self, done: Done) -> list[float]:
        """Mean coverage for other choices of the learned entries.

        Args:
            done: Finished jobs by name.

        Returns:
            One share for each draw of 12 out of all entries, the corners always
            among them; the others are held out.
        """
        rng = np.random.default_rng(0)
        others = [point for point in (*LEARNED, *HELD_OUT) if point not in CORNERS]
        shares = []
        for _ in range(DRAWS):
            chosen = rng.choice(len(others), len(LEARNED) - len(CORNERS), replace=False)
            points = [*CORNERS, *(others[i] for i in chosen)]
            shares.append(float(np.mean(self.coverage(done, points))))
        return shares

    def _prediction(
        self, regression: WeightRegression, done: Done, point: Point
    ) -> tuple[Vector, Vector, Vector]:
        """Mean, standard deviation and the learned curve over the phase."""
        mean, deviation = regression.predict(dict(zip(NAMES, point, strict=True)))
        weights = self._weights(done, point)
        basis = PeriodicBasis.of_size(weights.shape[1])
        predicted = Feedforward(("com.z",), basis, mean, deviation, "generalised")
        phase = sample_phases()
        return (
            predicted.mean(phase)[0],
            predicted.std(phase)[0],
            basis.evaluate(phase, weights)[0],
        )

    def report(self, done: Done) -> Section:
        """Errors on the held-out points and the coverage."""
        section = Section(
            title="Generalisation over amplitude and frequency",
            claim="The paper: the database should hold tens of entries and more than one "
            "parameter.",
        )
        identifiers = (
            ("held-out grid, stand-in: AC error, generalised / directly learned", "<= 2"),
            ("held-out grid, stand-in: AC error, generalised / linear interpolation", "<= 1"),
            ("held-out grid, stand-in: predictions inside 2 sigma [%]", "90 .. 99"),
        )
        if self.quick:
            section.found.append("The short form leaves this out.")
            section.goals += [Goal(name, goal, None) for name, goal in identifiers]
            return section
        rows, errors = self._rows(done)
        coverage = self.coverage(done, LEARNED)
        regression = self._regression(done, LEARNED)
        direct, generalised, linear = np.sqrt(np.mean(np.square(errors), axis=0))
        draws = self.coverage_of_draws(done)
        inside = 100 * float(np.mean(coverage))
        measured = (generalised / direct, generalised / linear, inside)
        section.goals += [
            Goal(name, goal, float(value))
            for (name, goal), value in zip(identifiers, measured, strict=True)
        ]
        scales = ", ".join(f"{name} {s:.2f}" for name, s in regression.length_scales.items())
        section.found += [
            f"{len(LEARNED)} entries, each learned with {ITERATIONS} stable iterations, predict "
            f"{len(HELD_OUT)} held-out ones; {len(DRIVEN)} of the predictions were driven. RMS "
            f"over those of the AC error: {1e3 * direct:.3f} mm directly learned, "
            f"{1e3 * generalised:.3f} mm generalised, {1e3 * linear:.3f} mm linear interpolation.",
            self._curve_sentence(done),
            self._repeatability_sentence(done),
            f"Length scales as shares of the learned range: {scales}.",
            f"{inside:.1f} % of the points of all held-out curves lie within two predicted "
            f"standard deviations; of single curves between {100 * min(coverage):.0f} % and "
            f"{100 * max(coverage):.0f} %. Over {DRAWS} random choices of {len(LEARNED)} entries, "
            f"corners included, with the others held out, it is {100 * np.mean(draws):.1f} % on "
            f"average, between {100 * min(draws):.1f} % and {100 * max(draws):.1f} %. The noise of "
            "the process was settled on another set of held-out places; these were new to it.",
        ]
        section.tables.append(
            Table(
                "AC error on held-out points [mm]",
                ["amplitude, frequency", "directly learned", "generalised", "linear"],
                rows,
            )
        )
        section.figures.append(
            Figure(
                "grid",
                "Predicted feedforward and the directly learned one (dashed) at three held-out "
                "points; below, their difference within two predicted standard deviations (band).",
                lambda: self._draw(done),
            )
        )
        return section

    def _curve_sentence(self, done: Done) -> str:
        """How far predicted curves are from learned ones, which no floor of tracking hides."""
        regression, linear = self._regression(done, LEARNED), self._interpolation(done)
        squares = []
        for point in HELD_OUT:
            mean, _, curve = self._prediction(regression, done, point)
            weights = linear([point])
            basis = PeriodicBasis.of_size(weights.shape[1])
            straight = basis.evaluate(sample_phases(), weights)[0]
            squares.append([np.mean((each - curve) ** 2) for each in (mean, straight)])
        generalised, interpolated = 1e3 * np.sqrt(np.mean(squares, axis=0))
        return (
            "Entries that are still learning rank nothing by their errors; the curves themselves "
            f"are off by {generalised:.2f} mm/s² RMS from the directly learned ones, those of "
            f"linear interpolation by {interpolated:.2f} mm/s²."
        )

    def _repeatability_sentence(self, done: Done) -> str:
        """What another sensor noise changes, as a share of the weights' variance."""
        weights = np.array([self._weights(done, point) for point in LEARNED])
        variance = float(np.mean(weights.var(axis=0)))
        shares = [
            # the difference of two has the noise of both
            np.mean((self._weights(done, point, OTHER_SEED) - self._weights(done, point)) ** 2)
            / (2 * variance)
            for point in REPEATED
        ]
        return (
            f"Learned once more with other sensor noise, {len(REPEATED)} entries differ by "
            f"{min(shares):.1e} to {max(shares):.1e} of the variance between entries; the process "
            f"takes {NOISE:.0e} for the noise of all."
        )

    def _rows(self, done: Done) -> tuple[list[list[str]], list[list[float]]]:
        rows, errors = [], []
        for point in DRIVEN:
            entry = done[self._entry(point).name]
            values = [
                entry.row(entry.last_iteration())["ac_rms_error_m"],
                *(
                    done[f"grid-{source}-{_label(point)}"].row("replay")["ac_rms_error_m"]
                    for source in SOURCES
                ),
            ]
            name = f"{100 * point[0]:g} cm, {point[1]:g} Hz"
            rows.append([name, *(millimetres(value) for value in values)])
            errors.append(values)
        return rows, errors

    def _draw(self, done: Done) -> Any:
        regression = self._regression(done, LEARNED)
        bands = [
            (
                f"{100 * point[0]:g} cm, {point[1]:g} Hz",
                *self._prediction(regression, done, point),
            )
            for point in SHOWN
        ]
        return draw_bands(sample_phases(), bands, "phase [rad]", "feedforward [m/s²]")


def _label(point: Point) -> str:
    return f"{point[0]:g}-{point[1]:g}"
