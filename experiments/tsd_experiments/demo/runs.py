"""The runs of the demonstration: learned, at lower gains, generalised."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from tsd_casadi.learning.feedforward import Feedforward, Kind
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_casadi.repetition.learn import learn
from tsd_casadi.repetition.record import context_of
from tsd_casadi.repetition.repeat import usual_axes
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_clients.console.table import console
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_experiments.demo.plan import ALL_AXES, MODEL_ERROR, REDUCED, REUSED, Plan, label_of


class DemoRuns:
    """The runs of the demonstration, in order.

    Attributes:
        runs: What was run so far, by label.
    """

    def __init__(
        self,
        robot: Robot,
        controller: RemoteController,
        learner: RemoteLearner,
        plan: Plan,
        seed: int,
        save_log: Callable[[str, Run], None],
    ) -> None:
        """Prepare the runs; ``save_log`` is given each with its label as it ends."""
        self.robot = robot
        self._save_log = save_log
        self.controller = controller
        self.learner = learner
        self.plan = plan
        self.seed = seed
        self.runs: dict[str, Run] = {}
        self._done = 0

    def play(self, report: Any) -> None:
        """Do all runs; report(done, total) moves the bar."""
        self._report = report
        self._simulator = MujocoSimulator(self.robot, MODEL_ERROR)
        self._perfect_model()
        self._one_amplitude()
        self._all_axes()
        self._other_amplitude()

    def _perfect_model(self) -> None:
        simulator = MujocoSimulator(self.robot, 0.0)
        self._run("perfect model, none", self.plan.amplitude, simulator=simulator)

    def _one_amplitude(self) -> None:
        amplitude = self.plan.amplitude
        learned = self._learn(amplitude)[1].feedforward
        self._run("constant", amplitude, learned.constant())
        self._run("P/5, none", amplitude, gains=REDUCED)
        self._run("P/5, learned, iteration 1", amplitude, learned, REDUCED)

    def _all_axes(self) -> None:
        """Learn all of the centre of mass at once, of which a wrong model moves every axis."""
        motion = Squat(self.plan.amplitude, self.plan.frequency)
        self._learn(self.plan.amplitude, usual_axes(self.robot, motion))

    def _other_amplitude(self) -> None:
        # the generalisation is to know the amplitudes of the database only
        for entry in self.learner.database().entries:
            self.learner.forget(entry.entry)
        for amplitude in self.plan.database:
            self._learn(amplitude)
        asked = self.plan.queried
        self._run("generalised", asked, self._query("generalised", asked))
        nearest = self._query("learned", self.plan.nearest)
        self._run(REUSED, asked, replace(nearest, kind="nearest"))
        self._learn(asked)

    def _query(self, kind: Kind, amplitude: float) -> Feedforward:
        return self.learner.query(
            Squat.name,
            robot=self.robot.name,
            kind=kind,
            axes=Squat(amplitude).axes(self.robot),
            context=context_of(self.robot),
            amplitude=amplitude,
            frequency=self.plan.frequency,
        )

    def _learn(self, amplitude: float, axes: Sequence[str] | None = None) -> list[Run]:
        """Learn a squat along some axes; by default as the paper does, along the moved one."""
        motion = Squat(amplitude, self.plan.frequency)

        def keep(run: Run, notes: list[str]) -> None:
            iteration = run.feedforward.iteration
            kind = f"learned, iteration {iteration}" if iteration else "none"
            if axes is not None:
                kind = f"{kind}, {ALL_AXES}"
            self._keep(label_of(amplitude, kind), run)
            for note in notes:
                console.print(f"note: {note}")

        return learn(
            self._simulator,
            self.controller,
            [motion],
            self.learner,
            axes=axes or motion.axes(self.robot),
            # what was learned along one axis would be served to a run of all
            restart=True,
            iterations=self.plan.iterations,
            rule="guarded",  # the paper's sum
            seed=self.seed,
            transport="zenoh",
            progress=lambda _motion, _index: self._progress,
            on_run=keep,
        )

    def _run(
        self,
        what: str,
        amplitude: float,
        feedforward: Feedforward | None = None,
        gains: Gains = UNCHANGED,
        simulator: MujocoSimulator | None = None,
    ) -> None:
        motion = Squat(amplitude, self.plan.frequency)
        run = (simulator or self._simulator).run(
            self.controller,
            motion,
            axes=motion.axes(self.robot),
            feedforward=feedforward,
            gains=gains,
            seed=self.seed,
            transport="zenoh",
            progress=self._progress,
        )
        self._keep(label_of(amplitude, what), run)

    def _progress(self, done: float, total: float) -> None:
        self._report(self._done + done / total, self.plan.number_of_runs)

    def _keep(self, label: str, run: Run) -> None:
        self._done += 1
        self.runs[label] = run
        self._save_log(label, run)
