"""Feedforward taken from elsewhere, and the gate that drops it where it harms."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.encoding.harmonics import sample_phases
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.repetition.repetition import HOLD
from tsd_casadi.robot.robot import Robot
from tsd_experiments.harness.case import Case, Outcome, replay_case
from tsd_experiments.harness.experiment import (
    Done,
    Experiment,
    Figure,
    Section,
    Table,
    millimetres,
)
from tsd_experiments.harness.jobs import Job, Result
from tsd_experiments.harness.work import learn, replay
from tsd_experiments.report.drawing import draw_errors

ITERATIONS = 2
WORLDS = {
    "ideal": Case(),
    "stand-in": Case(frequency=0.5, hardware=("all",)),
}
QUICK_WORLDS = {"ideal": Case(frequency=1.0)}
# how far a case must be from a tie for the gate to be judged by it
TIE = 0.05

Weights = list[float]


@dataclass(frozen=True)
class Donor:
    """Where a feedforward is borrowed from.

    Attributes:
        name: For tables.
        case: What it was learned in, from what it is used in.
        change: What happens to its weights on the way.
    """

    name: str
    case: Callable[[Case], Case]
    change: Callable[[Weights], Weights]


def _same(case: Case) -> Case:
    return case


def _unchanged(weights: Weights) -> Weights:
    return weights


def shift_by_half_a_lap(weights: Weights) -> Weights:
    """Weights of u(phi + pi): the right mean, the wrong time.

    Args:
        weights: Of u, (L,) [m/s^2].
    """
    basis, phase = PeriodicBasis.of_size(len(weights)), sample_phases()
    later = basis.evaluate(phase + np.pi, np.array([weights]))
    return [float(weight) for weight in basis.fit(phase, later)[0]]


DONORS = (
    Donor("5 cm instead of 3", lambda case: replace(case, amplitude=0.05), _unchanged),
    Donor("5.5 cm taller", lambda case: replace(case, height=0.055), _unchanged),
    Donor(
        "other frequency", lambda case: replace(case, frequency=0.75 - case.frequency), _unchanged
    ),
    Donor("half a lap late", _same, shift_by_half_a_lap),
    Donor("1.5 times", _same, lambda weights: [1.5 * weight for weight in weights]),
    # the error without feedforward is that of twice the feedforward, with the other sign
    Donor("1.9 times", _same, lambda weights: [1.9 * weight for weight in weights]),
    Donor("2.2 times", _same, lambda weights: [2.2 * weight for weight in weights]),
    Donor("3 times", _same, lambda weights: [3 * weight for weight in weights]),
    Donor("sign flipped", _same, lambda weights: [-weight for weight in weights]),
    Donor("-10 % robot", lambda case: replace(case, model_error=-0.1), _unchanged),
)
QUICK_DONORS = ("5 cm instead of 3", "half a lap late", "sign flipped")


def replay_gated(
    robot: Robot, controller: WholeBodyController, case: dict[str, object], weights: Weights
) -> Outcome:
    """Two runs with borrowed weights, without and with the gate.

    Args:
        robot: The robot.
        controller: Its controller.
        case: Plain data of the case.
        weights: (L,) [m/s^2].

    Returns:
        Rows 'ungated' and 'gated', the latter with 'dropped_at' [s] or None.
    """
    used = Case.of(case)
    outcome = replay_case(used, robot, controller, weights=weights, kind="nearest", label="ungated")
    gate = FeedforwardGate()
    gated = replay_case(
        used, robot, controller, weights=weights, kind="nearest", label="gated", compensators=[gate]
    )
    gated.rows[0]["dropped_at"] = gate.dropped_at
    return Outcome(outcome.rows + gated.rows, {**outcome.arrays, **gated.arrays})


@dataclass(frozen=True)
class Verdict:
    """What became of one borrowed feedforward.

    Attributes:
        world: Where it was used.
        donor: Where it is from.
        none: RMS error without it [m].
        ungated: With it [m]; None if the robot fell.
        gated: With the gate [m]; None if the robot fell.
        dropped_after: Laps of motion until the gate dropped it; None if kept.
    """

    world: str
    donor: str
    none: float
    ungated: float | None
    gated: float | None
    dropped_after: float | None

    @property
    def harmful(self) -> bool:
        """Whether it is worse than none."""
        return self.ungated is None or self.ungated > self.none

    @property
    def tied(self) -> bool:
        """Whether it hardly matters."""
        return self.ungated is not None and abs(self.ungated / self.none - 1) < TIE

    @property
    def right(self) -> bool:
        """Whether the gate dropped what harms and kept what helps."""
        return self.harmful == (self.dropped_after is not None)


class Borrowed(Experiment):
    """The gate on feedforward from other tasks, parameters and robots."""

    name = "borrowed"

    @property
    def _worlds(self) -> dict[str, Case]:
        return QUICK_WORLDS if self.quick else WORLDS

    @property
    def _donors(self) -> list[Donor]:
        return [each for each in DONORS if not self.quick or each.name in QUICK_DONORS]

    def _sources(self) -> Iterator[tuple[str, Donor, Case, Job]]:
        for world, case in self._worlds.items():
            for donor in self._donors:
                source = donor.case(case)
                changed = source != case
                which = donor.name.replace(" ", "_").replace("%", "percent")
                # learning errors are quickest at the robot's own gains
                job = Job(
                    f"borrowed-{world}-{which if changed else 'own'}",
                    learn,
                    {
                        "case": source.plain(),
                        "rule": "stable",
                        "iterations": 1 if self.quick else ITERATIONS,
                    },
                    cost=12,
                )
                yield world, donor, case, job

    def jobs(self, done: Done) -> list[Job]:
        """Learning elsewhere first, then the runs with what is borrowed."""
        jobs: dict[str, Job] = {}
        for world, donor, case, source in self._sources():
            jobs[source.name] = source
            if source.name in done:
                result = done[source.name]
                weights = donor.change(result.weights(result.last_iteration()))
                name = self._name(world, donor)
                arguments = {"case": case.plain(), "weights": weights}
                jobs[name] = Job(name, replay_gated, arguments, cost=8)
        for world, case in self._worlds.items():
            name = f"borrowed-{world}-none"
            jobs[name] = Job(name, replay, {"case": case.plain()}, cost=4)
        return list(jobs.values())

    def _name(self, world: str, donor: Donor) -> str:
        return f"borrowed-{world}-with-{donor.name.replace(' ', '_').replace('%', 'percent')}"

    def verdicts(self, done: Done) -> list[Verdict]:
        """One for each world and donor.

        Args:
            done: Finished jobs.
        """
        verdicts = []
        for world, donor, case, _ in self._sources():
            result = done[self._name(world, donor)]
            ungated, gated = result.row("ungated"), result.row("gated")
            dropped = gated["dropped_at"]
            verdicts.append(
                Verdict(
                    world=world,
                    donor=donor.name,
                    none=done[f"borrowed-{world}-none"].row("replay")["rms_error_m"],
                    ungated=ungated["rms_error_m"],
                    gated=gated["rms_error_m"],
                    dropped_after=None if dropped is None else (dropped - HOLD) * case.frequency,
                )
            )
        return verdicts

    def report(self, done: Done) -> Section:
        """What was dropped, when, and whether that was right."""
        verdicts = self.verdicts(done)
        clear = [each for each in verdicts if not each.tied]
        right = sum(each.right for each in clear)
        times = [each.dropped_after for each in verdicts if each.dropped_after is not None]
        found = [
            f"The gate decided rightly in {right} of {len(clear)} cases where the borrowed "
            f"feedforward makes more than {100 * TIE:.0f} % difference, and in "
            f"{sum(each.right for each in verdicts)} of all {len(verdicts)}."
        ]
        after = [
            each.gated / each.none
            for each in verdicts
            if each.dropped_after is not None and each.gated is not None
        ]
        if times and after:
            found.append(
                f"What it dropped it dropped {min(times):.2f} to {max(times):.2f} laps after the "
                f"motion began; its RMS error is then {min(after):.2f} to {max(after):.2f} times "
                "that without feedforward."
            )
        world, case = next(iter(self._worlds.items()))
        flipped = next(each for each in self._donors if each.name == "sign flipped")
        panel = _curves(done[f"borrowed-{world}-none"], done[self._name(world, flipped)])
        return Section(
            title="Borrowed feedforward",
            claim="Asked here: the feedforward of one task may be used for another. That is only "
            "safe if it is noticed when it does not fit: the gate predicts from the gains what "
            "the error would be without it, and drops it where that is smaller.",
            found=found,
            tables=[
                Table(
                    "RMS error over steady laps [mm]; 'dropped' in laps after the motion began",
                    ["used in", "borrowed", "none", "ungated", "gated", "dropped", "decision"],
                    [_row(each) for each in verdicts],
                )
            ],
            figures=[
                Figure(
                    "borrowed",
                    "A feedforward with the wrong sign, dropped by the gate.",
                    lambda: draw_errors([(f"{world}, {case.frequency:g} Hz", panel)]),
                )
            ],
        )


def _curves(none: Result, borrowed: Result) -> list[tuple[str, Result, str, str]]:
    return [
        ("no feedforward", none, "replay", "none"),
        ("sign flipped", borrowed, "ungated", "learned"),
        ("sign flipped, gated", borrowed, "gated", "reduced"),
    ]


def _row(verdict: Verdict) -> list[str]:
    dropped = verdict.dropped_after
    return [
        verdict.world,
        verdict.donor,
        millimetres(verdict.none),
        "fell" if verdict.ungated is None else millimetres(verdict.ungated),
        "fell" if verdict.gated is None else millimetres(verdict.gated),
        "kept" if dropped is None else f"{dropped:.2f}",
        ("right" if verdict.right else "wrong") + (" (tie)" if verdict.tied else ""),
    ]
