"""Low gain with feedforward against high gain without."""

from __future__ import annotations

from dataclasses import replace

from tsd_experiments.beyond.stiffness_or_feedforward.deflections import draw_deflections
from tsd_experiments.beyond.stiffness_or_feedforward.disturb import disturb
from tsd_experiments.beyond.stiffness_or_feedforward.sentences import (
    pushed_sentence,
    same_limit_sentence,
    shaken_sentence,
)
from tsd_experiments.beyond.stiffness_or_feedforward.sweep import sweep
from tsd_experiments.beyond.stiffness_or_feedforward.sweep_results import (
    highest_stable,
    needed,
    stiffness_for,
)
from tsd_experiments.beyond.stiffness_or_feedforward.tables import (
    IMPULSE,
    NOISE,
    NOISE_HEAD,
    PUSH_HEAD,
    PUSHES,
    VERDICTS,
    disturbed_cells,
    limit_cells,
    own_stiffness,
    verdicts,
    words_for,
)
from tsd_experiments.harness.case import SOFT, Case
from tsd_experiments.harness.experiment import Done, Experiment
from tsd_experiments.harness.job import Job, Result
from tsd_experiments.harness.learn_case import learn_case
from tsd_experiments.harness.section import Figure, Section, Table

WORLDS = {
    "ideal": Case(laps=4),
    "stand-in": Case(frequency=0.5, hardware=("all",), laps=5),
}
QUICK_WORLDS = {"ideal": Case(frequency=1.0, laps=4)}
FACTORS = (0.2, 1, 4, 16, 32, 64, 128, 256, 1024, 4096, 16384)
QUICK_FACTORS = (0.2, 4, 64)
ITERATIONS = 3
QUICK_ITERATIONS = 1
AC = "ac_rms_error_m"
# a contender must not stand at the very edge
MARGIN = 2.0


class StiffnessOrFeedforward(Experiment):
    """The paper's reason for learning: accuracy without stiffness."""

    name = "stiffness"

    @property
    def _worlds(self) -> dict[str, Case]:
        return QUICK_WORLDS if self.quick else WORLDS

    @property
    def _iterations(self) -> int:
        return QUICK_ITERATIONS if self.quick else ITERATIONS

    def jobs(self, done: Done) -> list[Job]:
        """Learn and sweep, then do what needs the stiffness that this leads to."""
        jobs = []
        for world, case in self._worlds.items():
            learned = Job(
                f"stiffness-{world}-learned",
                learn_case,
                {
                    "case": replace(case.at_stiffness(SOFT), laps=3).plain(),
                    "rule": "stable",
                    "iterations": self._iterations,
                },
                cost=6 * self._iterations,
            )
            without = self._sweep(f"stiffness-{world}-sweep", case, None)
            jobs += [learned, without]
            if learned.name not in done or without.name not in done:
                continue
            if not self.quick:
                weights = done[learned.name].weights(f"iteration {self._iterations}")
                jobs.append(self._sweep(f"stiffness-{world}-sweep-learned", case, weights))
            for name, (factor, given) in self._contenders(done, world).items():
                arguments = {
                    "case": case.plain(),
                    "factor": factor,
                    "weights": given,
                    "pushes": PUSHES,
                    "noise": None if self.quick else NOISE,
                }
                job_name = f"stiffness-{world}-{name.replace(' ', '_')}"
                jobs.append(Job(job_name, disturb, arguments, cost=20))
        return jobs

    def _sweep(self, name: str, case: Case, weights: list[float] | None) -> Job:
        arguments = {
            "case": replace(case, laps=2).plain(),
            "factors": list(QUICK_FACTORS if self.quick else FACTORS),
            "weights": weights,
            "bisect": 0 if self.quick else 3,
        }
        return Job(name, sweep, arguments, cost=6 if self.quick else 50)

    def _contenders(self, done: Done, world: str) -> dict[str, tuple[float, list[float] | None]]:
        """Choose factor on P and weights of who is pushed."""
        iteration, stiff = self._match(done, world)
        weights = done[f"stiffness-{world}-learned"].weights(f"iteration {iteration}")
        contenders: dict[str, tuple[float, list[float] | None]] = {
            "soft learned": (SOFT, weights),
            "stiff none": (stiff, None),
        }
        if not self.quick:
            contenders["own learned"] = (1.0, weights)
        return contenders

    def _match(self, done: Done, world: str) -> tuple[int, float]:
        """Find the most accurate iteration that stiffness alone equals, and the factor for it.

        If it can equal none, the first and half of what the robot stands.
        """
        rows = done[f"stiffness-{world}-sweep"].rows
        bound = highest_stable(rows) / MARGIN
        errors = done[f"stiffness-{world}-learned"].errors()[1:]
        factors = [stiffness_for(rows, float(error)) for error in errors]
        matches = [(each, index) for index, each in enumerate(factors, 1) if each <= bound]
        factor, iteration = max(matches, default=(bound, 1))
        return iteration, factor

    def report(self, done: Done) -> Section:
        """Report equal errors, then pushes and noise, then the highest stiffness."""
        found = []
        matched, winners, limits = [], [], []
        for world in self._worlds:
            own = own_stiffness(done[f"stiffness-{world}-learned"])
            rows = done[f"stiffness-{world}-sweep"].rows
            limit = highest_stable(rows)
            learned = done[f"stiffness-{world}-learned"]
            both = zip(learned.errors(), learned.errors(AC), strict=True)
            for index, (error, alternating) in enumerate(both):
                if index:
                    factor = stiffness_for(rows, float(error))
                    matched.append(
                        [
                            world,
                            str(index),
                            f"{1e3 * error:.2g}",
                            needed(own, factor, limit),
                            f"{factor / SOFT:.2g}",
                            f"{1e3 * alternating:.2g}",
                            needed(own, stiffness_for(rows, float(alternating), AC), limit),
                        ]
                    )
            results = self._disturbed(done, world)
            for name, (factor, _) in self._contenders(done, world).items():
                winners.append(
                    [
                        world,
                        f"{words_for(name)}, P = {own * factor:.3g}",
                        *disturbed_cells(results[name]),
                    ]
                )
            found.append(pushed_sentence(world, results, own * self._match(done, world)[1]))
            if not self.quick:
                found.append(shaken_sentence(world, results))
            sweeps = {"none": done[f"stiffness-{world}-sweep"].rows}
            if not self.quick:
                sweeps["learned"] = done[f"stiffness-{world}-sweep-learned"].rows
            limits += [[world, *cells] for cells in limit_cells(sweeps, own)]
        found += self._same_limit(done)
        found.append(
            "Most of the error without feedforward is an offset, which a constant feedforward or "
            "an integrator removes as well: the stiffness needed for the error without its mean "
            "(AC) is the fairer number."
        )
        found.append(
            "To hold its place against a push takes stiffness; feedforward gives accuracy "
            "without it and leaves the robot as compliant as the low gain makes it. What counts "
            "as winning in the columns on deflection is therefore a matter of the task."
        )
        return Section(
            title="Low gain with feedforward or high gain without",
            claim="The paper: feedforward gives the accuracy of a stiff robot to a soft one. The "
            "same error can be had both ways: what do the two do when they are pushed?",
            found=found,
            tables=[
                Table(
                    f"P without feedforward for the error of P = {own * SOFT:.3g} with it; ! above "
                    "the highest P that works, by extrapolation",
                    [
                        "world",
                        "iterations",
                        "RMS error [mm]",
                        "P needed",
                        "times",
                        "AC error [mm]",
                        "P needed for it",
                    ],
                    matched,
                ),
                Table(
                    f"{IMPULSE:g} N s on the base within 0.1 s, and {NOISE:g} N m of noise on "
                    "every joint; deflection [mm], time until it stays below 1 mm [s], largest "
                    "ground force, largest commanded torque as a share of its joint's limit",
                    ["world", "who", "RMS error", *PUSH_HEAD, *NOISE_HEAD],
                    winners,
                ),
                Table(
                    "Stiffer until the robot falls or the QP fails",
                    [
                        "world",
                        "feedforward",
                        "highest P that works",
                        "chatter there [% of torque limit per tick]",
                        "what ends it",
                    ],
                    limits,
                ),
                Table(
                    "Who wins where, that is has less (soft: P = "
                    f"{own * SOFT:.3g} with feedforward; stiff: equal error or half the limit; "
                    "equal: within 10 %; recovery, ground force and torque: pushed down)",
                    ["world", *VERDICTS],
                    [[world, *verdicts(self._disturbed(done, world))] for world in self._worlds],
                ),
            ],
            figures=[
                Figure(
                    "stiffness_pushed",
                    f"Deflection after {IMPULSE:g} N s, against the same run without it.",
                    lambda: draw_deflections(
                        {world: self._disturbed(done, world) for world in self._worlds}
                    ),
                )
            ],
        )

    def _disturbed(self, done: Done, world: str) -> dict[str, Result]:
        return {
            name: done[f"stiffness-{world}-{name.replace(' ', '_')}"]
            for name in self._contenders(done, world)
        }

    def _same_limit(self, done: Done) -> list[str]:
        if self.quick:
            return []
        ratios = {
            world: highest_stable(done[f"stiffness-{world}-sweep-learned"].rows)
            / highest_stable(done[f"stiffness-{world}-sweep"].rows)
            for world in self._worlds
        }
        return [same_limit_sentence(ratios)]
