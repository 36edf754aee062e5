"""Feedforward taken from elsewhere, and the gate that drops it where it harms."""

from __future__ import annotations

from collections.abc import Iterator

from tsd_casadi.repetition.repetition import HOLD
from tsd_experiments.beyond.borrowed_feedforward.donors import DONORS, QUICK_DONORS, Donor
from tsd_experiments.beyond.borrowed_feedforward.replay_gated import replay_gated
from tsd_experiments.beyond.borrowed_feedforward.verdict import TIE, Verdict
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.experiment import Done, Experiment
from tsd_experiments.harness.job import Job, Result
from tsd_experiments.harness.learn_case import learn_case
from tsd_experiments.harness.replay_case import replay_case
from tsd_experiments.harness.section import Figure, Section, Table
from tsd_experiments.report.curve import Curve
from tsd_experiments.report.drawing import draw_errors

ITERATIONS = 2
WORLDS = {
    "ideal": Case(),
    "stand-in": Case(frequency=0.5, hardware=("all",)),
}
QUICK_WORLDS = {"ideal": Case(frequency=1.0)}


class BorrowedFeedforward(Experiment):
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
                    learn_case,
                    {
                        "case": source.plain(),
                        "rule": "stable",
                        "iterations": 1 if self.quick else ITERATIONS,
                    },
                    cost=12,
                )
                yield world, donor, case, job

    def jobs(self, done: Done) -> list[Job]:
        """Learn elsewhere first, then run with what is borrowed."""
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
            jobs[name] = Job(name, replay_case, {"case": case.plain()}, cost=4)
        return list(jobs.values())

    def _name(self, world: str, donor: Donor) -> str:
        return f"borrowed-{world}-with-{donor.name.replace(' ', '_').replace('%', 'percent')}"

    def verdicts(self, done: Done) -> list[Verdict]:
        """Judge the gate for each world and donor."""
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
        """Report what was dropped, when, and whether that was right."""
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
                "motion began (below 0: standing before it); its RMS error is then "
                f"{min(after):.2f} to {max(after):.2f} times that without feedforward."
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
                    "RMS error over steady laps [mm]; 'dropped' in laps after the motion began, "
                    "below 0 while standing before it",
                    ["used in", "borrowed", "none", "ungated", "gated", "dropped", "decision"],
                    [each.cells() for each in verdicts],
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


def _curves(none: Result, borrowed: Result) -> list[Curve]:
    return [
        Curve.stored("no feedforward", none, "replay", "none"),
        Curve.stored("sign flipped", borrowed, "ungated", "learned"),
        Curve.stored("sign flipped, gated", borrowed, "gated", "reduced"),
    ]
