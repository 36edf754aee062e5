from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from tsd_casadi import Command, Controller, Database, Robot, Run, Squat, State, Tick, learn
from tsd_casadi.exceptions import (
    DatabaseError,
    EntryNotFound,
    IncompatibleEntry,
    InvalidValue,
    SimulationError,
    TsdError,
)
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.motions.circle import Circle
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.sway import Sway
from tsd_casadi.repetition.record import record_of
from tsd_casadi.repetition.repeat import usual_axes
from tsd_casadi.tick.format import Status
from tsd_clients import MujocoSimulator

SQUAT = Squat(amplitude=0.01, frequency=1.0)
AT = {"amplitude": 0.01, "frequency": 1.0, "height": 0.0}
AXES = ("com.z",)


class Stub:
    """A controller whose replies are spoilt from some tick on."""

    def __init__(self, controller: Controller, first: int, status: Status, torque: float) -> None:
        self.format = controller.format
        self._controller = controller
        self._first, self._status, self._torque = first, status, torque
        self._ticks = 0

    def command(self) -> Command:
        return self._controller.command()

    def tick(self, state: State, command: Command) -> Tick:
        tick = self._controller.tick(state, command)
        if self._ticks >= self._first:
            tick.reply[0] = self._status
            tick.tau[:] *= self._torque
        self._ticks += 1
        return tick


class Learned:
    """Two iterations of the paper's sum, learned once for all tests that only look."""

    def __init__(self, simulator: MujocoSimulator, controller: Controller, path: Path) -> None:
        self.seen: list[tuple[Run, list[str]]] = []
        self.progress: list[tuple[Any, int]] = []
        with Database(path) as database:
            self.runs = learn(
                simulator,
                controller,
                [SQUAT],
                database,
                axes=AXES,
                iterations=2,
                rule="plain",
                laps=2,
                on_run=lambda run, notes: self.seen.append((run, notes)),
                progress=lambda motion, index: self.progress.append((motion, index)),
            )
            (self.entry,) = database.entries()
            self.served = database.query("squat", **AT)


@pytest.fixture(scope="module")
def learned(
    simulator: MujocoSimulator,
    controller: Controller,
    tmp_path_factory: pytest.TempPathFactory,
) -> Learned:
    return Learned(simulator, controller, tmp_path_factory.mktemp("learned") / "d.sqlite")


@pytest.fixture
def database(tmp_path: Path) -> Any:
    with Database(tmp_path / "d.sqlite") as opened:
        yield opened


def z(run: Run) -> AxisError:
    """How the vertical axis was tracked."""
    return run.errors["com.z"]


def measures(error: AxisError) -> dict[str, float]:
    """Take what the run measured, without what the learner notes of its laps."""
    plain = error.plain()
    return {name: plain[name] for name in plain if name not in ("laps", "deviation", "scatter")}


def numbers(entry: Entry) -> list[tuple[int, bool]]:
    """Number of each iteration and whether it was tested."""
    return [(iteration.number, iteration.errors is not None) for iteration in entry.iterations]


def test_n_iterations_are_n_plus_one_runs(learned: Learned) -> None:
    assert len(learned.runs) == 3
    assert [run.feedforward.iteration for run in learned.runs] == [0, 1, 2]
    assert [run.feedforward.kind for run in learned.runs] == ["none", "learned", "learned"]
    assert all(run.steady and not run.fell and not run.failures for run in learned.runs)


def test_error_decreases_with_every_iteration(learned: Learned) -> None:
    first, second, third = (z(run) for run in learned.runs)
    assert second.rms < 0.2 * first.rms
    assert third.rms < second.rms
    assert third.true_rms < 0.2 * first.true_rms
    # not only the offset that an integrator would remove, too
    assert third.ac_rms < 0.5 * first.ac_rms
    assert third.mean_abs_feedback < 0.2 * first.mean_abs_feedback
    ranks = [run.rank for run in learned.runs]
    assert ranks == sorted(ranks, reverse=True)


def test_the_entry_holds_every_iteration_with_its_errors(
    learned: Learned, robot: Robot, controller: Controller
) -> None:
    entry = learned.entry
    assert numbers(entry) == [(0, True), (1, True), (2, True)]
    for run, iteration in zip(learned.runs, entry.iterations, strict=True):
        assert iteration.errors is not None
        assert measures(iteration.errors["com.z"]) == measures(z(run))
        np.testing.assert_array_equal(iteration.weights, run.feedforward.weights)
    context = Context(robot.body_fingerprint, robot.formulation_fingerprint)
    assert entry.key == EntryKey.of("hermes_lower", "squat", "1", ("com.z",), AT, context)
    assert entry.declaration == SQUAT.declaration()
    # those of the learned axis, z
    assert entry.circumstances.gains["P"] == [controller.command()["com.P"][2]]
    assert entry.circumstances.setting == learned.runs[0].settings
    assert entry.circumstances.setting["period_s"] == 1e-3


def test_each_iteration_adds_what_the_feedback_had_to_add(learned: Learned) -> None:
    basis = learned.entry.basis
    for before, after in zip(learned.entry.iterations, learned.entry.iterations[1:], strict=False):
        laps = learned.runs[before.number].laps
        phase = np.concatenate([lap.phase for lap in laps])
        feedback = np.concatenate([lap.feedback for lap in laps], axis=1)
        added = np.linalg.lstsq(basis.values(phase), feedback[0], rcond=None)[0]
        np.testing.assert_allclose(after.weights[0], before.weights[0] + added, atol=1e-6)


def test_the_best_iteration_is_served_and_known_to_be_tested(learned: Learned) -> None:
    assert learned.served.iteration == 2
    assert learned.served.provenance["tested"] is True
    told = learned.served.provenance["errors"]["com.z"]
    assert told["unit"] == "m"
    assert {**told, **measures(z(learned.runs[2])), "unit": "m"} == told


def test_callbacks_see_every_run_in_order(learned: Learned) -> None:
    assert [run for run, _ in learned.seen] == learned.runs
    assert [notes for _, notes in learned.seen] == [[], [], []]
    assert learned.progress == [(SQUAT, 0), (SQUAT, 1), (SQUAT, 2)]


def test_an_entry_is_continued_and_then_restarted(
    simulator: MujocoSimulator, controller: Controller, database: Database
) -> None:
    first = learn(simulator, controller, [SQUAT], database, axes=AXES, iterations=1, laps=2)
    assert [run.feedforward.iteration for run in first] == [0, 1]
    on = learn(simulator, controller, [SQUAT], database, axes=AXES, iterations=1, laps=2)
    # the best so far is repeated and learned from
    assert [run.feedforward.iteration for run in on] == [1, 2]
    assert z(on[0]).rms == z(first[1]).rms
    assert z(on[1]).rms < z(first[1]).rms
    (entry,) = database.entries()
    assert numbers(entry) == [(0, True), (1, True), (2, True)]

    again = learn(
        simulator, controller, [SQUAT], database, axes=AXES, iterations=1, laps=2, restart=True
    )
    assert [run.feedforward.iteration for run in again] == [0, 1]
    assert again[0].errors == first[0].errors
    (restarted,) = database.entries()
    assert numbers(restarted) == [(0, True), (1, True)]
    assert restarted.identifier != entry.identifier


def test_several_motions_become_several_entries(
    simulator: MujocoSimulator, controller: Controller, database: Database
) -> None:
    motions = [SQUAT, Squat(0.02, 1.0)]
    runs = learn(simulator, controller, motions, database, axes=AXES, laps=2)
    assert [run.motion for run in runs] == [motions[0]] * 2 + [motions[1]] * 2
    assert [dict(entry.key.parameters)["amplitude"] for entry in database.entries()] == [0.01, 0.02]
    # another motion's entry is no reason to start with a feedforward
    assert [run.feedforward.kind for run in runs] == ["none", "learned"] * 2
    generalized = database.query("squat", amplitude=0.015, frequency=1.0)
    run = simulator.run(controller, Squat(0.015, 1.0), laps=2, feedforward=generalized)
    assert z(run).rms < 0.2 * z(runs[0]).rms


def test_the_rule_is_handed_on(
    simulator: MujocoSimulator, controller: Controller, database: Database
) -> None:
    learn(simulator, controller, [SQUAT], database, laps=2, rule="plain")
    assert database.entries()[0].rule.name == "plain"


def test_a_fallen_run_is_not_recorded(
    simulator: MujocoSimulator, controller: Controller, database: Database
) -> None:
    limp = Stub(controller, first=100, status=Status.OK, torque=0.0)
    with pytest.raises(SimulationError, match=r"fell in squat amplitude=0\.01 frequency=1") as e:
        learn(simulator, limp, [SQUAT], database, laps=2)
    assert "nothing was recorded" in str(e.value)
    assert database.entries() == []


def test_a_fall_during_a_restart_keeps_what_was_learned(
    simulator: MujocoSimulator, controller: Controller, database: Database, learned: Learned
) -> None:
    database.record(record_of(learned.runs[0], simulator.robot))
    limp = Stub(controller, first=100, status=Status.OK, torque=0.0)
    with pytest.raises(SimulationError):
        learn(simulator, limp, [SQUAT], database, axes=AXES, laps=2, restart=True)
    assert numbers(database.entries()[0]) == [(0, True), (1, False)]


def test_what_was_recorded_before_a_fall_stays(
    simulator: MujocoSimulator, controller: Controller, database: Database
) -> None:
    seen: list[Run] = []
    first = 5000 + 100  # in the second run
    limp = Stub(controller, first=first, status=Status.OK, torque=0.0)
    with pytest.raises(SimulationError):
        learn(simulator, limp, [SQUAT], database, laps=2, on_run=lambda run, _: seen.append(run))
    assert len(seen) == 1
    assert seen[0].ticks <= first
    assert numbers(database.entries()[0]) == [(0, True), (1, False)]


def test_an_unsteady_run_is_not_recorded(
    simulator: MujocoSimulator, controller: Controller, learned: Learned
) -> None:
    run = learned.runs[0]
    unsteady = Run(**{**vars(run), "steady": False, "laps_run": 14})
    with pytest.raises(SimulationError, match=r"did not settle in 14 laps.*nothing was recorded"):
        record_of(unsteady, simulator.robot)


def test_a_recording_holds_the_steady_laps_and_the_applied_weights(
    simulator: MujocoSimulator, controller: Controller, learned: Learned
) -> None:
    run = learned.runs[1]
    recording = record_of(run, simulator.robot)
    assert recording.laps is run.laps
    np.testing.assert_array_equal(recording.applied, run.feedforward.weights)
    assert recording.errors == run.errors


@pytest.mark.parametrize("iterations", [0, -1])
def test_less_than_one_iteration_is_refused(
    simulator: MujocoSimulator, controller: Controller, database: Database, iterations: int
) -> None:
    with pytest.raises(InvalidValue, match="iterations"):
        learn(simulator, controller, [SQUAT], database, iterations=iterations)


def test_a_motion_out_of_range_is_refused(
    simulator: MujocoSimulator, controller: Controller, database: Database
) -> None:
    with pytest.raises(InvalidValue, match="amplitude"):
        learn(simulator, controller, [Squat(0.5, 1.0)], database)
    assert database.entries() == []


class Grumpy:
    """A learner that fails in one way or another."""

    def __init__(self, error: TsdError) -> None:
        self.error = error

    def query(self, motion: str, **_: Any) -> Any:
        raise self.error

    def record(self, recording: Any) -> Any:
        raise AssertionError("nothing to record")


@pytest.mark.parametrize(
    "error", [DatabaseError(Path("d.sqlite"), "is locked", "wait"), IncompatibleEntry("other")]
)
def test_a_learner_that_cannot_answer_stops_before_the_first_run(
    simulator: MujocoSimulator, controller: Controller, error: TsdError
) -> None:
    with pytest.raises(type(error)):
        learn(simulator, controller, [SQUAT], Grumpy(error))


def test_all_motions_are_checked_before_the_first_run(
    simulator: MujocoSimulator, controller: Controller, learned: Learned
) -> None:
    class Untouched(Grumpy):
        def query(self, motion: str, **_: Any) -> Any:
            raise AssertionError("a run was about to start")

    with pytest.raises(InvalidValue, match="amplitude"):
        learn(
            simulator,
            controller,
            [SQUAT, Squat(0.5, 1.0)],
            Untouched(IncompatibleEntry("unused")),
        )


def test_a_run_whose_ticks_failed_is_not_learned_from(
    simulator: MujocoSimulator, controller: Controller, learned: Learned
) -> None:
    run = learned.runs[0]
    failed = Run(**{**vars(run), "failures": {"infeasible": run.ticks}})
    with pytest.raises(SimulationError):
        record_of(failed, simulator.robot)


class Scripted:
    """A learner that knows nothing and runs that go as written."""

    def __init__(self, errors: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
        self.updates: list[bool] = []
        self.errors = iter(errors)
        self.contractions: tuple[Any, ...] = ("an account",)
        monkeypatch.setattr("tsd_casadi.repetition.learn.repeat", self.repeat)
        monkeypatch.setattr("tsd_casadi.repetition.learn.record_of", lambda *_: None)

    def repeat(self, *_: Any, **__: Any) -> Any:
        error = next(self.errors)

        class OfThisError:
            rank = error
            vetoes = ()
            remarks = ()
            fell, steady, aborted = False, True, ""
            failures: ClassVar[dict[str, int]] = {}
            at_limits: ClassVar[dict[str, int]] = {}
            missed: ClassVar[dict[str, int]] = {}

        return OfThisError()

    def query(self, motion: str, /, **_: Any) -> Any:
        raise EntryNotFound("nothing")

    def record(self, recording: Any, instruction: Instruction) -> Any:
        self.updates.append(instruction.update)
        return self, []


@pytest.mark.parametrize(
    ("errors", "patience", "runs"),
    [
        ([8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.12], 1, 7),  # always better
        ([8.0, 1.0, 0.99, 0.99, 0.99, 0.99, 0.99], 2, 4),  # hardly better
        ([8.0, 1.0, 2.0, 1.0, 0.5, 0.49, 0.49], 3, 7),  # worse, the best again, better
        ([8.0, 1.0, 2.0, 1.0, 1.5, 0.5, 0.25], 3, 5),
        ([8.0, 8.0, 8.0, 8.0, 8.0, 8.0, 8.0], None, 7),
        # nothing to learn from the first one on
        ([8.0, 8.0, 8.0, 8.0, 8.0, 8.0, 8.0], 2, 3),
        ([8.0, 8.0, 7.8, 7.8, 7.8, 7.8, 7.8], 2, 5),
    ],
)
def test_patience_ends_when_nothing_becomes_better(
    simulator: MujocoSimulator,
    controller: Controller,
    monkeypatch: pytest.MonkeyPatch,
    errors: list[float],
    patience: int | None,
    runs: int,
) -> None:
    script = Scripted(errors, monkeypatch)
    done = learn(simulator, controller, [SQUAT], script, iterations=6, patience=patience)
    assert len(done) == runs
    # the last run only shows: nothing untested is left behind
    assert script.updates == [True] * (runs - 1) + [False]


def test_the_account_of_each_motion_is_handed_on(
    simulator: MujocoSimulator, controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = Scripted([2.0, 1.0] * 2, monkeypatch)
    seen: list[Any] = []
    motions = [SQUAT, Squat(0.02, 1.0)]
    learn(simulator, controller, motions, script, on_learned=lambda *what: seen.append(what))
    assert seen == [(motion, ("an account",)) for motion in motions]


@pytest.mark.parametrize("patience", [0, -1])
def test_no_patience_at_all_is_refused(
    simulator: MujocoSimulator, controller: Controller, database: Database, patience: int
) -> None:
    with pytest.raises(InvalidValue, match="patience"):
        learn(simulator, controller, [SQUAT], database, patience=patience)


def test_stable_learning_of_the_simulated_robot(
    simulator: MujocoSimulator, controller: Controller, database: Database, learned: Learned
) -> None:
    accounts: list[Any] = []
    runs = learn(
        simulator,
        controller,
        [SQUAT],
        database,
        axes=AXES,
        iterations=2,
        laps=2,
        rule="stable",
        on_learned=lambda _, found: accounts.extend(found),
    )
    # without lag no worse than the plain sum, and right where the model is
    assert z(runs[2]).rms < z(learned.runs[2]).rms
    (account,) = accounts
    assert account.axis == "com.z"
    assert account.frequency[1] == 1.0
    assert account.observed[1] < account.plain[1]


@pytest.mark.parametrize("harm", [False, True])
def test_a_first_feedforward_starts_what_is_new_and_goes_if_it_harms(
    simulator: MujocoSimulator,
    controller: Controller,
    database: Database,
    learned: Learned,
    harm: bool,
) -> None:
    first = replace(learned.served, kind="generalised")
    if harm:
        first = replace(first, weights=-first.weights)
    notes: list[str] = []
    runs = learn(
        simulator,
        controller,
        [SQUAT],
        database,
        axes=AXES,
        laps=2,
        first=first,
        on_run=lambda _, remarks: notes.extend(remarks),
    )
    if harm:
        assert runs[0].feedforward.kind == "none"
        assert any("dropped" in note for note in notes)
    else:
        assert runs[0].feedforward.kind == "generalised"
        assert z(runs[0]).rms < 0.2 * z(learned.runs[0]).rms
        (note,) = notes
        assert "the feedforward generalised from entry 1 was kept" in note
    assert runs[1].feedforward.kind == "learned"
    # an entry that exists is continued with what it has
    on = learn(simulator, controller, [SQUAT], database, axes=AXES, laps=2, first=first)
    assert on[0].feedforward.kind == "learned"


def test_every_repetition_may_have_its_own_seed(
    simulator: MujocoSimulator, controller: Controller, tmp_path: Path
) -> None:
    with Database(tmp_path / "d.sqlite") as database:
        runs = learn(simulator, controller, [SQUAT], database, laps=2, seed=[3, 4])
        assert [run.settings["seed"] for run in runs] == [3, 4]
        assert not np.array_equal(runs[0].log["q"][0], runs[1].log["q"][0])
        with pytest.raises(InvalidValue, match=r"seeds is 3, expected one, or one for each of 2"):
            learn(simulator, controller, [SQUAT], database, seed=[1, 2, 3])


@pytest.mark.parametrize("motion", [Sway(0.03, 0.5), Circle(0.015, 0.5)])
def test_all_axes_of_the_centre_of_mass_are_learned_together(
    simulator: MujocoSimulator, controller: Controller, database: Database, motion: Motion
) -> None:
    moved = motion.axes(simulator.robot)
    runs = learn(simulator, controller, [motion], database, laps=2)
    assert runs[0].learned == usual_axes(simulator.robot, motion)
    assert set(runs[0].learned) == {"com.x", "com.y", "com.z"}
    alone = learn(simulator, controller, [motion], database, axes=moved, laps=2)
    assert len(database.entries()) == 2
    for axis in moved:
        first, last = (run.errors[axis].rms for run in (runs[0], runs[-1]))
        assert last < 0.2 * first
        # alone, the others stay off, and with them what they do to this one
        assert last < alone[-1].errors[axis].rms + 0.03 * first
    # the offset that its weight leaves, which is not learned along what moves alone
    assert runs[-1].errors["com.z"].rms < 0.01 * runs[0].errors["com.z"].rms


def test_an_entry_of_one_axis_is_asked_for_along_more_and_it_is_said(
    simulator: MujocoSimulator, controller: Controller, database: Database, learned: Learned
) -> None:
    recording = record_of(learned.runs[0], simulator.robot)
    database.record(recording, Instruction(find_rule("guarded")))
    notes: list[str] = []
    runs = learn(
        simulator,
        controller,
        [SQUAT],
        database,
        laps=2,
        on_run=lambda _, said: notes.extend(said),
    )
    assert runs[0].learned == ("com.z", "com.x", "com.y")
    assert any(re.search(r"nothing was learned along .*com\.x, com\.y", note) for note in notes)
    assert runs[0].log["feedforward"][:, 0].any()
    assert not runs[0].log["feedforward"][:, 1:].any()


def test_what_cannot_be_learned_away_is_half_a_steps_damping_unless_the_plant_says_when(
    robot: Robot, controller: Controller, tmp_path: Path
) -> None:
    """D (dt / 2) xdd / P, where positions and velocities are taken for simultaneous."""
    perfect, sway = MujocoSimulator(robot), Sway(0.04, 0.25)
    left = {}
    for name, velocity_time in (("told", perfect.velocity_time), ("untold", 0.0)):
        perfect.velocity_time = velocity_time
        with Database(tmp_path / f"{name}.sqlite") as database:
            runs = learn(
                perfect, controller, [sway], database, axes=("com.y",), laps=2, rule="plain"
            )
        left[name] = runs[-1].errors["com.y"].rms
    (P,), (D,) = runs[-1].gains["P"], runs[-1].gains["D"]
    acceleration = 0.04 * (2 * np.pi * 0.25) ** 2 / np.sqrt(2)
    assert left["untold"] == pytest.approx(D * 0.5e-3 * acceleration / P, rel=0.1)
    assert left["told"] < 1e-6
