"""Generalisation over amplitude and frequency on the stand-in."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tsd_casadi.encoding.harmonics import sample_phases
from tsd_casadi.state import Matrix
from tsd_experiments.beyond.two_parameters.grid import GRID, NAMES, Point
from tsd_experiments.beyond.two_parameters.predictions import Predictions
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.experiment import Done, Experiment
from tsd_experiments.harness.job import Job
from tsd_experiments.harness.learn_case import learn_case
from tsd_experiments.harness.replay_case import replay_case
from tsd_experiments.harness.section import Figure, Goal, Section, Table, millimeters
from tsd_experiments.report.drawing import draw_bands

OTHER_SEED = 1
SOURCES = ("generalised", "linear")


class TwoParameters(Experiment):
    """12 learned entries, 36 held out: amplitude and frequency, on the stand-in."""

    name = "grid"
    grid = GRID
    case = Case(hardware=("all",))

    def jobs(self, done: Done) -> list[Job]:
        """Learn the entries, then drive their predictions; nothing in the short form."""
        if self.quick:
            return []
        entries = [self._entry(point) for point in self.grid.all]
        entries += [self._entry(point, OTHER_SEED) for point in self.grid.repeated]
        if any(job.name not in done for job in entries):
            return entries
        predictions = self.predictions(done)
        regression = predictions.regression(self.grid.learned)
        linear = predictions.interpolation(self.grid.learned)
        jobs = []
        for point in self.grid.driven:
            sources = {
                "generalised": regression.predict(dict(zip(NAMES, point, strict=True)))[0][0],
                "linear": linear([point])[0],
            }
            for source, weights in sources.items():
                arguments = {
                    "case": self._case(point).plain(),
                    "weights": [float(value) for value in weights],
                    "kind": "generalised",
                }
                name = f"grid-{source}-{_label(point)}"
                jobs.append(Job(name, replay_case, arguments, cost=4))
        return entries + jobs

    def _case(self, point: Point) -> Case:
        return replace(self.case, amplitude=point[0], frequency=point[1])

    def _entry(self, point: Point, seed: int = 0) -> Job:
        arguments = {
            "case": replace(self._case(point), seed=seed).plain(),
            "rule": "stable",
            "iterations": self.grid.iterations,
        }
        cost = (1 + 3.5 / point[1]) * (self.grid.iterations + 1) / 3
        kind = "again" if seed else "entry"
        return Job(f"grid-{kind}-{_label(point)}", learn_case, arguments, cost=cost)

    def _weights(self, done: Done, point: Point, seed: int = 0) -> Matrix:
        result = done[self._entry(point, seed).name]
        return np.array([result.weights(result.last_iteration())])

    def predictions(self, done: Done) -> Predictions:
        """Collect what was learned directly, to predict from some of it."""
        return Predictions({point: self._weights(done, point) for point in self.grid.all})

    def report(self, done: Done) -> Section:
        """Report the errors on the held-out points and the coverage."""
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
        grid, predictions = self.grid, self.predictions(done)
        rows, errors = self._rows(done)
        coverage = predictions.coverage(grid.learned)
        regression = predictions.regression(grid.learned)
        direct, generalized, linear = np.sqrt(np.mean(np.square(errors), axis=0))
        draws = predictions.coverage_of_draws(grid.corners, len(grid.learned), grid.draws)
        inside = 100 * float(np.mean(coverage))
        measured = (generalized / direct, generalized / linear, inside)
        section.goals += [
            Goal(name, goal, float(value))
            for (name, goal), value in zip(identifiers, measured, strict=True)
        ]
        scales = ", ".join(f"{name} {s:.2f}" for name, s in regression.length_scales.items())
        section.found += [
            f"{len(grid.learned)} entries, each learned with {grid.iterations} stable iterations, "
            f"predict {len(grid.held_out)} held-out ones; {len(grid.driven)} of the predictions "
            f"were driven. RMS over those of the AC error: {1e3 * direct:.3f} mm directly learned, "
            f"{1e3 * generalized:.3f} mm generalised, {1e3 * linear:.3f} mm linear interpolation.",
            self._curve_sentence(predictions),
            self._repeatability_sentence(done),
            f"Length scales as shares of the learned range: {scales}.",
            f"{inside:.1f} % of the points of all held-out curves lie within two predicted "
            f"standard deviations; of single curves between {100 * min(coverage):.0f} % and "
            f"{100 * max(coverage):.0f} %. Over {grid.draws} random choices of "
            f"{len(grid.learned)} entries, corners included, with the others held out, it is "
            f"{100 * np.mean(draws):.1f} % on average, between {100 * min(draws):.1f} % and "
            f"{100 * max(draws):.1f} %.",
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

    def _curve_sentence(self, predictions: Predictions) -> str:
        """Tell how far predicted curves are from learned ones; no floor of tracking hides it."""
        generalized, interpolated = predictions.off_by(self.grid.learned, self.grid.held_out)
        return (
            "Entries that are still learning rank nothing by their errors; the curves themselves "
            f"are off by {1e3 * generalized:.2f} mm/s² RMS from the directly learned ones, those "
            f"of linear interpolation by {1e3 * interpolated:.2f} mm/s²."
        )

    def _repeatability_sentence(self, done: Done) -> str:
        """Tell what another sensor noise changes, as a share of the weights' variance."""
        weights = np.array([self._weights(done, point) for point in self.grid.learned])
        variance = float(np.mean(weights.var(axis=0)))
        shares = [
            # the difference of two has the noise of both
            np.mean((self._weights(done, point, OTHER_SEED) - self._weights(done, point)) ** 2)
            / (2 * variance)
            for point in self.grid.repeated
        ]
        return (
            f"Learned once more with other sensor noise, {len(shares)} entries differ by "
            f"{min(shares):.1e} to {max(shares):.1e} of the variance between entries."
        )

    def _rows(self, done: Done) -> tuple[list[list[str]], list[list[float]]]:
        rows, errors = [], []
        for point in self.grid.driven:
            entry = done[self._entry(point).name]
            values = [
                entry.row(entry.last_iteration())["ac_rms_error_m"],
                *(
                    done[f"grid-{source}-{_label(point)}"].row("replay")["ac_rms_error_m"]
                    for source in SOURCES
                ),
            ]
            name = f"{100 * point[0]:g} cm, {point[1]:g} Hz"
            rows.append([name, *(millimeters(value) for value in values)])
            errors.append(values)
        return rows, errors

    def _draw(self, done: Done) -> Any:
        predictions = self.predictions(done)
        regression = predictions.regression(self.grid.learned)
        bands = [
            (
                f"{100 * point[0]:g} cm, {point[1]:g} Hz",
                *predictions.curves(regression, point),
            )
            for point in self.grid.shown
        ]
        return draw_bands(sample_phases(), bands, "phase [rad]", "feedforward [m/s²]")


def _label(point: Point) -> str:
    return f"{point[0]:g}-{point[1]:g}"
