"""The paper's proposal: a squat that fails from nothing starts from what an easier one learned."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from tsd_experiments.harness.case import SOFT, TALL, Case
from tsd_experiments.harness.experiment import Done, Experiment
from tsd_experiments.harness.job import Job, Result
from tsd_experiments.harness.learn_case import learn_case
from tsd_experiments.harness.section import Figure, Section, Table, millimeters
from tsd_experiments.report.drawing import draw_lines

RULES = ("plain", "stable")
ITERATIONS = 4
QUICK_ITERATIONS = 1
EASIER_ITERATIONS = 2
# the controller believes the robot so much lighter than it is
MODEL_ERRORS = (-0.2, -0.25, -0.3)
QUICK_MODEL_ERRORS = (-0.3,)
REACHED = 1e-3  # m


@dataclass(frozen=True)
class Start:
    """Where learning starts from.

    Attributes:
        name: For tables.
        easier: The case that is learned first; None to start from nothing.
    """

    name: str
    easier: Callable[[Case], Case] | None


def _stiffer(case: Case) -> Case:
    return replace(case, p_scale=1.0, d_scale=1.0)


STARTS = (
    Start("nothing", None),
    Start("P = 50", _stiffer),
    # a first working solution needs the gains that it works with
    Start("P = 50, home", lambda case: replace(_stiffer(case), height=0.0)),
    Start("P = 50, -10 %", lambda case: replace(_stiffer(case), model_error=-0.1)),
)
QUICK_STARTS = ("nothing", "P = 50")


class Bootstrapping(Experiment):
    """The paper's proposal for tasks that have no working solution yet."""

    name = "bootstrapping"

    @property
    def _errors(self) -> tuple[float, ...]:
        return QUICK_MODEL_ERRORS if self.quick else MODEL_ERRORS

    @property
    def _starts(self) -> list[Start]:
        return [each for each in STARTS if not self.quick or each.name in QUICK_STARTS]

    def _case(self, error: float) -> Case:
        case = Case(height=TALL, model_error=error).at_stiffness(SOFT)
        if self.quick:
            return replace(case, frequency=1.0, laps=2)
        return replace(case, frequency=0.5)

    def jobs(self, done: Done) -> list[Job]:
        """Learn the easier cases and from nothing, then start from the easier ones."""
        iterations = QUICK_ITERATIONS if self.quick else ITERATIONS
        jobs: dict[str, Job] = {}
        for error in self._errors:
            hard = self._case(error)
            for start in self._starts:
                first = None
                if start.easier is not None:
                    easier = self._easier(error, start)
                    jobs[easier.name] = easier
                    if easier.name not in done:
                        continue
                    first = done[easier.name].weights(f"iteration {EASIER_ITERATIONS}")
                for rule in RULES:
                    name = self._name(error, start, rule)
                    arguments = {
                        "case": hard.plain(),
                        "rule": rule,
                        "iterations": iterations,
                        "first": first,
                    }
                    jobs[name] = Job(name, learn_case, arguments, cost=3 * iterations)
        return list(jobs.values())

    def _easier(self, error: float, start: Start) -> Job:
        assert start.easier is not None
        arguments = {
            "case": start.easier(self._case(error)).plain(),
            "rule": "stable",
            "iterations": EASIER_ITERATIONS,
        }
        name = f"bootstrapping-{error:g}-easier-{_slug(start.name)}"
        return Job(name, learn_case, arguments, cost=8)

    def _name(self, error: float, start: Start, rule: str) -> str:
        return f"bootstrapping-{error:g}-from-{_slug(start.name)}-{rule}"

    def report(self, done: Done) -> Section:
        """Report errors by iteration."""
        rows, lines, found = [], [], []
        for error in self._errors:
            reached = dict.fromkeys((start.name for start in self._starts), 0)
            falls = dict.fromkeys(reached, 0)
            for start in self._starts:
                for rule in RULES:
                    result = done[self._name(error, start, rule)]
                    errors = result.errors()
                    label = f"{100 * error:g} %, from {start.name}, {rule}"
                    cells = [millimeters(float(each)) for each in errors]
                    fell = _stopped(result)
                    reached[start.name] += not fell and bool(errors[-1] < REACHED)
                    falls[start.name] += fell
                    missing = len(self._columns) - len(cells)
                    rows.append([label, *cells, *(["fell"] if fell else []), *["–"] * missing])
                    rows[-1] = rows[-1][: len(self._columns) + 1]
                    if error == min(self._errors) and len(errors):
                        legend = f"from {start.name}, {rule}"
                        lines.append((legend, list(range(len(errors))), list(1e3 * errors)))
            told = ", ".join(
                f"from {name} {count}" + (f" ({falls[name]} fell)" if falls[name] else "")
                for name, count in reached.items()
            )
            found.append(
                f"Model error {100 * error:g} %: below {1e3 * REACHED:g} mm within "
                f"{len(self._columns) - 1} iterations, of {len(RULES)} rules: {told}."
            )
        worst = f"{100 * min(self._errors):g} %"
        return Section(
            title="Bootstrapping: from an easier squat to one that fails from nothing",
            claim="The paper: learning needs a working solution first. For a task that has none, "
            "the paper proposes the feedforward of a less complex task.",
            found=[
                "The hard task is the squat with P = 10 and D of the same damping ratio, knees at "
                f"1.0 rad. What it starts from was learned in {EASIER_ITERATIONS} iterations: the "
                "same squat with the robot's own gains ('P = 50'), the same in the lower home "
                "posture ('P = 50, home'), or with a smaller model error ('P = 50, -10 %'). Only "
                "the first of them differs in gains alone.",
                *found,
            ],
            tables=[
                Table("RMS error after each iteration [mm]", ["case", *self._columns], rows),
            ],
            figures=[
                Figure(
                    "bootstrapping",
                    f"RMS error by iteration with a model error of {worst}; a line that ends "
                    "early ends in a fall.",
                    lambda: draw_lines(lines, "iteration", "RMS error [mm]"),
                )
            ],
        )

    @property
    def _columns(self) -> list[str]:
        return [str(i) for i in range(1 + (QUICK_ITERATIONS if self.quick else ITERATIONS))]


def _stopped(result: Result) -> bool:
    return any("stopped" in row for row in result.rows)


def _slug(name: str) -> str:
    return name.replace(" ", "").replace("=", "").replace(",", "-").replace("%", "percent")
