"""What happened while learning, in order, for the table and the JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import typer

from tsd_casadi.generalization.suggestion import Suggestion
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.rules.rule import Rule
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_cli.actions.label import label_of
from tsd_cli.actions.true_error import tell_prior, tell_risen
from tsd_cli.options.learning import PlaceOptions
from tsd_clients.console.learner_tables import print_contractions, print_places
from tsd_clients.console.run_tables import print_runs


class Story:
    """What happened while learning, in order.

    Attributes:
        summaries: Of the runs, plain data.
        places: Where learning went by itself, plain data.
        was_aborted: Whether something ended a repetition early.
        fell: Whether the robot fell in one.
        remarks: What to know of all of it.
    """

    def __init__(self) -> None:
        """Begin with nothing."""
        self.was_aborted = self.fell = False
        self.summaries: list[dict[str, Any]] = []
        self.places: list[dict[str, Any]] = []
        self.remarks: list[str] = []
        self._learned: list[tuple[Motion, Sequence[Contraction]]] = []

    def keep_run(self, run: Run, notes: list[str]) -> None:
        """Note a run, and show at once what was remarked."""
        self.summaries.append({"label": label_of(run), **run.summary(), "notes": notes})
        for note in notes:
            typer.echo(f"note: {note}", err=True)

    def keep_aborted(self, run: Run) -> None:
        """Note what was run of a repetition that ended early, or that was not recorded."""
        self.was_aborted |= bool(run.aborted)
        self.fell |= run.fell
        # of a whole one a learner that is busy may have recorded all the same
        how = "not recorded, as far as is known"
        if run.aborted:
            how = f"aborted after {run.ticks} periods, nothing was recorded of it"
        self.keep_run(run, [how])

    def keep_contractions(self, motion: Motion, contractions: Sequence[Contraction]) -> None:
        """Note what iterations leave of a motion's error."""
        self._learned.append((motion, contractions))

    def keep_place(self, place: Suggestion, before: int) -> None:
        """Note a place with the errors of the runs there, those from a number on."""
        runs = self.summaries[before:]
        self.places.append(
            {
                "parameters": place.parameters,
                "standard_deviation": place.standard_deviation,
                "errors": [summary["errors"] for summary in runs],
                "ranks": [summary["rank"] for summary in runs],
            }
        )

    def plain(self) -> dict[str, Any]:
        """Give plain data for JSON."""
        return {
            "runs": self.summaries,
            "remarks": self.remarks,
            "places": self.places,
            "contractions": [
                {"parameters": motion.parameters, **asdict(each)}
                for motion, contractions in self._learned
                for each in contractions
            ],
        }

    def show(self, motion: Motion, rule: Rule, places: PlaceOptions) -> None:
        """Print it as tables."""
        declaration = motion.declaration()
        if places.auto:
            print_places(declaration, self.places)
        else:
            print_runs(f"learning {motion.name}", self.summaries)
        if rule.is_by_harmonic and self._learned:
            # of the rest the JSON tells: a table for each axis of each place is no overview
            at, contractions = self._learned[-1]
            print_contractions(declaration, at.parameters, contractions[:1])
        for remark in self.remarks:
            typer.echo(f"note: {remark}", err=True)

    def conclude(self, robot: Robot, axes: Sequence[str], correction: str) -> None:
        """Note what no run by itself tells: what learning leaves of the true error.

        Args:
            axes: Learned axes.
            correction: Fingerprint of the centre of mass in use; empty for the model's.
        """
        if any(summary["laps_measured"] for summary in self.summaries) and not correction:
            self.remarks += tell_prior(robot, axes)
        by_motion: dict[str, list[dict[str, Any]]] = {}
        for summary in self.summaries:
            by_motion.setdefault(str(summary["parameters"]), []).append(summary)
        for runs in by_motion.values():
            self.remarks += tell_risen(runs)
