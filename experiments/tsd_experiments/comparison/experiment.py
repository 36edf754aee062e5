"""Learned task accelerations against what a user would do instead."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from tsd_experiments.comparison.compare import compare, compare_generalized
from tsd_experiments.comparison.generalized_methods import GENERALIZED
from tsd_experiments.comparison.methods import METHODS
from tsd_experiments.comparison.scenario import SCENARIOS
from tsd_experiments.comparison.tables import (
    TRANSFERS,
    draw_pushes,
    methods_table,
    torque_or_acceleration_sentence,
    winners_sentence,
)
from tsd_experiments.harness.experiment import Done, Experiment
from tsd_experiments.harness.job import Job, Result
from tsd_experiments.harness.outcome import Outcome
from tsd_experiments.harness.section import Figure, Section

QUICK_METHODS = ("none", "observer", "constant", "joint torque")


class InsteadOfLearning(Experiment):
    """Integral action, observer, constant, joint torques, identification."""

    name = "methods"

    @property
    def _scenarios(self) -> tuple[str, ...]:
        return ("stand-in",) if self.quick else tuple(SCENARIOS)

    @property
    def _transfers(self) -> tuple[str, ...]:
        return TRANSFERS[:1] if self.quick else TRANSFERS

    def jobs(self, done: Done) -> list[Job]:
        """Compare each method in each scenario, as learned, transferred and generalised."""
        names = QUICK_METHODS if self.quick else tuple(METHODS)
        jobs = [
            Job(
                _name(scenario, method),
                compare,
                {"method": method, "scenario": scenario, "transfers": list(self._transfers)},
                cost=(60 if "identified" in method else 25) + (5 if "learn" in method else 0),
            )
            for scenario in self._scenarios
            for method in names
        ]
        if self.quick:
            return jobs
        return jobs + [
            Job(
                _name(scenario, f"{method}, generalised"),
                compare_generalized,
                {"method": method, "scenario": scenario},
                cost=60,
            )
            for scenario in self._scenarios
            for method in GENERALIZED
        ]

    def report(self, done: Done) -> Section:
        """Report one table per scenario, and the deflections."""
        section = Section(
            title="What a user would do instead",
            claim="The paper: learning joint torques might do the same but generalises poorly; "
            "identification never describes a complex system completely.",
        )
        for scenario in self._scenarios:
            results = self._results(done, scenario, compare)
            generalized = self._results(done, scenario, compare_generalized)
            section.tables.append(methods_table(scenario, results, generalized, self._transfers))
            section.found.append(winners_sentence(scenario, results))
            if generalized:
                sentence = torque_or_acceleration_sentence(scenario, results, generalized)
                section.found.append(sentence)
            section.figures.append(
                Figure(
                    f"push_{scenario.replace('-', '_')}",
                    f"{scenario}: deflection by a downward push of 10 N s, by method.",
                    partial(draw_pushes, results),
                )
            )
        section.found += [
            "The observer's bandwidth, the regularisation of the identification and the defaults "
            "of the learner were all chosen on these simulated robots. One seed each.",
            "The observer is a PID in disguise, with gains P + g D, D + g and g P for a bandwidth "
            "g: it tracks well everywhere without learning anything, and resists a push as "
            "a stiff controller does; that is what feedforward avoids.",
        ]
        return section

    def _results(
        self, done: Done, scenario: str, function: Callable[..., Outcome]
    ) -> dict[str, Result]:
        return {
            job.arguments["method"]: done[job.name]
            for job in self.jobs(done)
            if job.arguments["scenario"] == scenario and job.function == function
        }


def _name(scenario: str, method: str) -> str:
    plain = method.replace(", ", "-").replace(" / ", "-").replace(" ", "_")
    return f"methods-{scenario}-{plain}"
