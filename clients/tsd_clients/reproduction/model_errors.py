"""Where learning works and where it fails: errors, gains and postures."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tsd_clients.reproduction.case import Case
from tsd_clients.reproduction.drawing import draw_lines
from tsd_clients.reproduction.experiment import (
    Done,
    Experiment,
    Figure,
    Section,
    Table,
    millimetres,
)
from tsd_clients.reproduction.jobs import Job, Result

STIFFNESS = {10: 0.2, 20: 0.4, 50: 1.0, 100: 2.0, 200: 4.0, 400: 8.0}
UNIFORM = (0.1, -0.1, 0.2, -0.2, 0.4, -0.4)
POSTURES = {"home": 0.0, "tall": 0.055}
PER_LINK = (0.1, 0.2, 0.4)
SEEDS = range(10)
ITERATIONS = 2


@dataclass(frozen=True)
class _Point:
    """One cell of the sweep."""

    posture: str
    error: float
    P: int

    @property
    def name(self) -> str:
        return f"sweep-{self.posture}-{self.error:+g}-P{self.P}"

    def job(self, case: Case) -> Job:
        changed = replace(case, height=POSTURES[self.posture], model_error=self.error)
        plain = changed.at_stiffness(STIFFNESS[self.P]).plain()
        arguments = {"case": plain, "rule": "plain", "iterations": ITERATIONS}
        return Job(self.name, "work:learn", arguments, cost=8)


class ModelErrors(Experiment):
    """Uniform errors at all gains in two postures; random signs over seeds."""

    name = "model_errors"
    case = Case(laps=2)

    def jobs(self, done: Done) -> list[Job]:
        """One job per cell."""
        return [*(point.job(self.case) for point in self._points()), *self._random()]

    def _points(self) -> list[_Point]:
        errors = (-0.2,) if self.quick else UNIFORM
        gains = (10, 50) if self.quick else tuple(STIFFNESS)
        return [
            _Point(posture, error, P) for posture in POSTURES for error in errors for P in gains
        ]

    def _random(self) -> list[Job]:
        errors = (0.1,) if self.quick else PER_LINK
        seeds = range(2) if self.quick else SEEDS
        return [
            Job(
                f"sweep-links-{error:g}-seed{seed}",
                "work:learn",
                {
                    "case": replace(
                        self.case, model_error=0.0, link_error=error, link_seed=seed
                    ).plain(),
                    "rule": "plain",
                    "iterations": ITERATIONS,
                },
                cost=8,
            )
            for error in errors
            for seed in seeds
        ]

    def report(self, done: Done) -> Section:
        """Tables by posture, and one of random signs with true and estimated errors."""
        points = self._points()
        gains = sorted({point.P for point in points})
        failures = [point for point in points if _outcome(done[point.name]) != "learns"]
        tables = [
            Table(
                f"{posture}: RMS error after {ITERATIONS} iterations (without feedforward) [mm]",
                ["model error", *(f"P = {P}" for P in gains)],
                [
                    [
                        f"{100 * error:+g} %",
                        *(_cell(done[_Point(posture, error, P).name]) for P in gains),
                    ]
                    for error in sorted({point.error for point in points})
                ],
            )
            for posture in POSTURES
        ]
        tables.append(self._random_table(done))
        names = ", ".join(
            f"{point.posture} {100 * point.error:+g} % at P = {point.P} "
            f"({_outcome(done[point.name])})"
            for point in failures
        )
        return Section(
            title="How wrong the model may be",
            claim="With 20 % error the squat 'would not achieve meaningful squatting with the "
            "given parameter set'.",
            found=[
                f"Of {len(points)} combinations {len(points) - len(failures)} learn"
                + (f"; the others: {names}." if names else ".")
                + " A failure with 20 % is a matter of low gain and nearly straight knees, not of "
                "20 %: the offset grows as 1 / P and pushes the robot where its knees are "
                "singular.",
                "With random signs the estimated error vanishes, the true one does not: the "
                "controller sees its own wrong centre of mass.",
            ],
            tables=tables,
            figures=[
                Figure(
                    "model_errors",
                    f"RMS error after {ITERATIONS} iterations by stiffness; lines that end have no "
                    "result there.",
                    lambda: draw_lines(self._lines(done), "P [1/s²]", "RMS error [mm]", logx=True),
                )
            ],
        )

    def _lines(self, done: Done) -> list[tuple[str, list[float], list[float]]]:
        lines = []
        points = self._points()
        for posture in POSTURES:
            for error in sorted({point.error for point in points}):
                cells = [
                    (float(point.P), float(1e3 * done[point.name].errors()[-1]))
                    for point in points
                    if (point.posture, point.error) == (posture, error)
                    and len(done[point.name].errors()) > ITERATIONS
                ]
                if cells:
                    x, y = zip(*cells, strict=True)
                    lines.append((f"{posture} {100 * error:+g} %", list(x), list(y)))
        return lines

    def _random_table(self, done: Done) -> Table:
        rows = []
        for job in self._random():
            result = done[job.name]
            estimated, true = result.errors(), result.errors("true_rms_error_m")
            link_error = job.arguments["case"]["link_error"]
            seed = job.arguments["case"]["link_seed"]
            rows.append(
                [
                    f"{100 * link_error:g} %, {seed}",
                    *(millimetres(error) for error in (estimated[0], estimated[-1])),
                    *(millimetres(error) for error in (true[0], true[-1])),
                    _outcome(result),
                ]
            )
        return Table(
            f"Random sign per link, home, P = 50: RMS error [mm] before and after {ITERATIONS} "
            "iterations",
            ["error, seed", "estimated, none", "learned", "true, none", "learned", ""],
            rows,
        )


def _outcome(result: Result) -> str:
    errors = result.errors()
    if len(errors) <= ITERATIONS:
        reason = str(result.rows[-1].get("stopped", ""))
        return (
            "fell" if "fell" in reason else "failed ticks" if "safe" in reason else "never settled"
        )
    if not np.all(np.isfinite(errors)) or errors[-1] > 0.5 * errors[0]:
        return "does not converge"
    return "learns"


def _cell(result: Result) -> str:
    errors = result.errors()
    outcome = _outcome(result)
    if len(errors) <= ITERATIONS:
        return outcome
    mark = "" if outcome == "learns" else " !"
    return f"{1e3 * errors[-1]:.3g} ({1e3 * errors[0]:.3g}){mark}"
