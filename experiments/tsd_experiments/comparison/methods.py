"""Learned task accelerations against what a user would do instead."""

from __future__ import annotations

from typing import Any

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.repetition.repetition import HOLD
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.disturbances import Push
from tsd_experiments.comparison.alternative_methods import METHODS
from tsd_experiments.comparison.alternatives import (
    SCENARIOS,
    compare_generalised,
    describe,
    drive,
    prepare,
)
from tsd_experiments.comparison.generalized_methods import GENERALISED
from tsd_experiments.harness.case import Outcome
from tsd_experiments.harness.experiment import (
    Done,
    Experiment,
    Figure,
    Section,
    Table,
    millimetres,
)
from tsd_experiments.harness.jobs import Job, Result
from tsd_experiments.report.drawing import draw_lines

IMPULSE = (0.0, 0.0, -10.0)  # N s
PUSH_DURATION = 0.1  # s
SEEN = 2.0  # s after the push
RECOVERED = 1e-3  # m, as in the comparison of stiffness
# what is compared: an identified controller computes the centre of mass with its
# own inertias, and only the simulated robot's error means the same for all
MEASURE = "true_ac_rms_error_m"
TRANSFERS = ("none", "amplitude", "frequency", "posture")
HEADINGS = ("as learned", "at 5 cm", "at the other frequency", "5.5 cm higher")
QUICK_METHODS = ("none", "observer", "constant", "joint torque")


def compare(
    robot: Robot, controller: WholeBodyController, method: str, scenario: str, transfers: list[str]
) -> Outcome:
    """Prepare one method, run it as learned and transferred, then push it.

    Args:
        robot: The robot.
        controller: Its controller.
        method: Key of ``METHODS``.
        scenario: Key of ``SCENARIOS``.
        transfers: What to measure; 'none' is the first.

    Returns:
        One row per transfer and one labelled 'push'; the deflection by the
        push over time.
    """
    setting = SCENARIOS[scenario]
    alternative, bench = prepare(robot, controller, method, setting)
    outcome = Outcome()
    calm: Run | None = None
    for name in transfers:
        run = drive(alternative, bench, setting, setting.transfers[name])
        row = describe(run, alternative, setting)
        outcome.rows.append({"label": name, "method": method, **row})
        calm = calm or run
    assert calm is not None  # the first transfer is the squat itself
    # in the second lap, where the robot is lowest
    start = HOLD + 1.25 / setting.squat.frequency
    push = Push(start, PUSH_DURATION, IMPULSE)
    pushed = drive(alternative, bench, setting, setting.squat, [push])
    count = min(calm.ticks, pushed.ticks)
    time = calm.log["time"][:count] - start
    deflection = pushed.log["true_error"][:count] - calm.log["true_error"][:count]
    peak = float(np.abs(deflection[time >= 0]).max(initial=0.0))
    outcome.rows.append({"label": "push", "deflection_m": peak, "fell": pushed.fell})
    window = (time >= -0.1) & (time < SEEN)
    outcome.arrays["push/time"] = time[window]
    outcome.arrays["push/deflection"] = deflection[window]
    return outcome


def generalise(
    robot: Robot, controller: WholeBodyController, method: str, scenario: str
) -> Outcome:
    """Learn at 2, 4, 6 and 8 cm, generalise to 5 cm.

    Args:
        robot: The robot.
        controller: Its controller.
        method: Key of ``GENERALISED``.
        scenario: Key of ``SCENARIOS``.

    Returns:
        One row labelled 'generalised'.
    """
    row = compare_generalised(robot, controller, method, SCENARIOS[scenario])
    return Outcome([{"label": "generalised", **row}])


class Methods(Experiment):
    """Integral action, observer, constant, joint torques, identification."""

    name = "methods"

    def jobs(self, done: Done) -> list[Job]:
        """One job per method and scenario."""
        scenarios = ("stand-in",) if self.quick else tuple(SCENARIOS)
        names = QUICK_METHODS if self.quick else tuple(METHODS)
        transfers = TRANSFERS[:1] if self.quick else TRANSFERS
        jobs = [
            Job(
                _name(scenario, method),
                compare,
                {"method": method, "scenario": scenario, "transfers": list(transfers)},
                cost=(60 if "identified" in method else 25) + (5 if "learn" in method else 0),
            )
            for scenario in scenarios
            for method in names
        ]
        if self.quick:
            return jobs
        return jobs + [
            Job(
                _name(scenario, f"{method}, generalised"),
                generalise,
                {"method": method, "scenario": scenario},
                cost=60,
            )
            for scenario in scenarios
            for method in GENERALISED
        ]

    def report(self, done: Done) -> Section:
        """One table per scenario, and the deflections."""
        scenarios = ("stand-in",) if self.quick else tuple(SCENARIOS)
        section = Section(
            title="What a user would do instead",
            claim="The paper: learning joint torques might do the same but generalises poorly; "
            "identification never describes a complex system completely.",
        )
        for scenario in scenarios:
            results = {
                job.arguments["method"]: done[job.name]
                for job in self.jobs(done)
                if job.arguments["scenario"] == scenario and job.function == compare
            }
            section.tables.append(self._table(done, scenario, results))
            section.found.append(_winners(scenario, results))
            if "task acceleration" in results:
                section.found.append(self._torque_or_acceleration(done, scenario, results))
            section.figures.append(
                Figure(
                    f"push_{scenario.replace('-', '_')}",
                    f"{scenario}: deflection by a downward push of 10 N s, by method.",
                    lambda results=results: _draw_push(results),  # type: ignore[misc]
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

    def _torque_or_acceleration(self, done: Done, scenario: str, results: dict[str, Result]) -> str:
        """Whether joint torques generalise worse, as the paper expects."""
        pairs = {
            heading: [results[method].row(label)[MEASURE] for method in GENERALISED]
            for label, heading in zip(TRANSFERS, HEADINGS, strict=True)
        }
        names = [_name(scenario, f"{method}, generalised") for method in GENERALISED]
        pairs["generalised to 5 cm"] = [done[name].row("generalised")[MEASURE] for name in names]
        pairs = {heading: pair for heading, pair in pairs.items() if None not in pair}
        told = ", ".join(
            f"{heading} {torque / acceleration:.2g}"
            for heading, (acceleration, torque) in pairs.items()
        )
        worse = sum(torque > 1.1 * acceleration for acceleration, torque in pairs.values())
        return (
            f"{scenario}, error with learned joint torques by error with task accelerations of the "
            f"same plain sum: {told}. The paper's expectation that joint torques generalise "
            f"poorly shows in {worse} of {len(pairs)}."
        )

    def _table(self, done: Done, scenario: str, results: dict[str, Result]) -> Table:
        transfers = TRANSFERS[:1] if self.quick else TRANSFERS
        rows = []
        for method, result in results.items():
            own, push = result.row("none"), result.row("push")
            name = _name(scenario, f"{method}, generalised")
            generalised = (
                millimetres(done[name].row("generalised")[MEASURE]) if name in done else "–"
            )
            rows.append(
                [
                    method,
                    str(own["numbers_learned"]),
                    millimetres(own["rms_error_m"]),
                    millimetres(own["true_rms_error_m"]),
                    *(_ac(result, transfer) for transfer in transfers),
                    generalised,
                    millimetres(push["deflection_m"], 2),
                    _recovery(result),
                ]
            )
        return Table(
            f"{scenario}: errors of the centre of mass [mm]; where nothing else is said the true "
            "error without its mean (AC); * where the run never became steady; recovered: below "
            f"{1e3 * RECOVERED:g} mm for good",
            [
                "method",
                "numbers learned",
                "RMS as the controller sees it",
                "true RMS",
                *HEADINGS[: len(transfers)],
                "generalised to 5 cm",
                "deflection by 10 N s",
                "recovered after [s]",
            ],
            rows,
        )


def _winners(scenario: str, results: dict[str, Result]) -> str:
    def best(label: str) -> str:
        measured = {
            method: result.row(label)[MEASURE]
            for method, result in results.items()
            if any(row["label"] == label for row in result.rows)
            and result.row(label)[MEASURE] is not None
        }
        winner = min(measured, key=lambda method: measured[method])
        return f"{winner} ({1e3 * measured[winner]:.3f} mm)"

    labels = [row["label"] for row in next(iter(results.values())).rows if row["label"] != "push"]
    parts = [f"{HEADINGS[TRANSFERS.index(label)]} {best(label)}" for label in labels]
    softest = max(results, key=lambda method: results[method].row("push")["deflection_m"])
    deflection = results[softest].row("push")["deflection_m"]
    return (
        f"{scenario}, smallest true AC error: {', '.join(parts)}. Gives way most to a push: "
        f"{softest} ({1e3 * deflection:.1f} mm)."
    )


def _recovery(result: Result) -> str:
    """Until the deflection stays small."""
    if result.row("push").get("fell"):
        return "fell"
    time, deflection = result.arrays["push/time"], result.arrays["push/deflection"]
    away = np.flatnonzero(np.abs(deflection) > RECOVERED)
    if not away.size:
        return "0.00"
    return f"{time[away[-1]]:.2f}" if away[-1] < len(time) - 1 else f"not within {SEEN:g}"


def _ac(result: Result, transfer: str) -> str:
    row: dict[str, Any] = result.row(transfer)
    if row["fell"]:
        return "fell"
    return millimetres(row[MEASURE]) + ("" if row["steady"] else " *")


def _name(scenario: str, method: str) -> str:
    plain = method.replace(", ", "-").replace(" / ", "-").replace(" ", "_")
    return f"methods-{scenario}-{plain}"


def _draw_push(results: dict[str, Result]) -> Any:
    lines = [
        (method, result.arrays["push/time"][::20], 1e3 * result.arrays["push/deflection"][::20])
        for method, result in results.items()
    ]
    return draw_lines(lines, "time after the push [s]", "deflection [mm]", logy=False)
