from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

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
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.repetition.record import record_of
from tsd_casadi.tick.format import Status
from tsd_clients import MujocoSimulator

SQUAT = Squat(amplitude=0.01, frequency=1.0)
AT = {"amplitude": 0.01, "frequency": 1.0, "height": 0.0}


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
    """Two iterations, learned once for all tests that only look."""

    def __init__(self, simulator: MujocoSimulator, controller: Controller, path: Path) -> None:
        self.seen: list[tuple[Run, list[str]]] = []
        self.progress: list[tuple[Any, int]] = []
        with Database(path) as database:
            self.runs = learn(
                simulator,
                controller,
                [SQUAT],
                database,
                iterations=2,
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


def numbers(entry: Entry) -> list[tuple[int, bool]]:
    """Number of each iteration and whether it was tested."""
    return [(iteration.number, iteration.errors is not None) for iteration in entry.iterations]


def test_n_iterations_are_n_plus_one_runs(learned: Learned) -> None:
    assert len(learned.runs) == 3
    assert [run.feedforward.iteration for run in learned.runs] == [0, 1, 2]
    assert [run.feedforward.kind for run in learned.runs] == ["none", "learned", "learned"]
    assert all(run.steady and not run.fell and not run.failures for run in learned.runs)


def test_error_decreases_with_every_iteration(learned: Learned) -> None:
    first, second, third = (run.rms_error for run in learned.runs)
    assert second < 0.2 * first
    assert third < second
    assert learned.runs[2].true_rms_error < 0.2 * learned.runs[0].true_rms_error
    # not only the offset that an integrator would remove, too
    assert learned.runs[2].ac_rms_error < 0.5 * learned.runs[0].ac_rms_error
    assert learned.runs[2].mean_abs_feedback < 0.2 * learned.runs[0].mean_abs_feedback


def test_the_entry_holds_every_iteration_with_its_errors(
    learned: Learned, robot: Robot, controller: Controller
) -> None:
    entry = learned.entry
    assert numbers(entry) == [(0, True), (1, True), (2, True)]
    for run, iteration in zip(learned.runs, entry.iterations, strict=True):
        assert iteration.errors == run.errors()
        np.testing.assert_array_equal(iteration.weights, run.feedforward.weights)
    assert entry.key == EntryKey.of("hermes_lower", "squat", ("com.z",), AT)
    assert entry.context.model == robot.fingerprint
    assert entry.context.formulation == f"{controller.format.layout_hash:016x}"
    # those of the learned axis, z
    assert entry.context.gains["P"] == [controller.command()["com.P"][2]]


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
    assert learned.served.provenance["errors"] == learned.runs[2].errors()


def test_callbacks_see_every_run_in_order(learned: Learned) -> None:
    assert [run for run, _ in learned.seen] == learned.runs
    assert [notes for _, notes in learned.seen] == [[], [], []]
    assert learned.progress == [(SQUAT, 0), (SQUAT, 1), (SQUAT, 2)]


def test_an_entry_is_continued_and_then_restarted(
    simulator: MujocoSimulator, controller: Controller, database: Database
) -> None:
    first = learn(simulator, controller, [SQUAT], database, iterations=1, laps=2)
    assert [run.feedforward.iteration for run in first] == [0, 1]
    on = learn(simulator, controller, [SQUAT], database, iterations=1, laps=2)
    # the best so far is repeated and learned from
    assert [run.feedforward.iteration for run in on] == [1, 2]
    assert on[0].rms_error == first[1].rms_error
    assert on[1].rms_error < first[1].rms_error
    (entry,) = database.entries()
    assert numbers(entry) == [(0, True), (1, True), (2, True)]

    again = learn(simulator, controller, [SQUAT], database, iterations=1, laps=2, restart=True)
    assert [run.feedforward.iteration for run in again] == [0, 1]
    assert again[0].errors() == first[0].errors()
    (restarted,) = database.entries()
    assert numbers(restarted) == [(0, True), (1, True)]
    assert restarted.identifier != entry.identifier


def test_several_motions_become_several_entries(
    simulator: MujocoSimulator, controller: Controller, database: Database
) -> None:
    motions = [SQUAT, Squat(0.02, 1.0)]
    runs = learn(simulator, controller, motions, database, laps=2)
    assert [run.motion for run in runs] == [motions[0]] * 2 + [motions[1]] * 2
    assert [dict(entry.key.parameters)["amplitude"] for entry in database.entries()] == [0.01, 0.02]
    # another motion's entry is no reason to start with a feedforward
    assert [run.feedforward.kind for run in runs] == ["none", "learned"] * 2
    generalized = database.query("squat", amplitude=0.015, frequency=1.0)
    run = simulator.run(controller, Squat(0.015, 1.0), laps=2, feedforward=generalized)
    assert run.rms_error < 0.2 * runs[0].rms_error


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
    database.record(record_of(learned.runs[0], simulator.robot, controller))
    limp = Stub(controller, first=100, status=Status.OK, torque=0.0)
    with pytest.raises(SimulationError):
        learn(simulator, limp, [SQUAT], database, laps=2, restart=True)
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
        record_of(unsteady, simulator.robot, controller)


def test_a_recording_holds_the_steady_laps_and_the_applied_weights(
    simulator: MujocoSimulator, controller: Controller, learned: Learned
) -> None:
    run = learned.runs[1]
    recording = record_of(run, simulator.robot, controller)
    assert recording.laps is run.laps
    np.testing.assert_array_equal(recording.applied, run.feedforward.weights)
    assert recording.errors == run.errors()


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
        record_of(failed, simulator.robot, controller)


class Scripted:
    """A learner that knows nothing and runs that go as written."""

    def __init__(self, errors: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
        self.updates: list[bool] = []
        self.errors = iter(errors)
        self.contractions: tuple[Any, ...] = ("an account",)
        monkeypatch.setattr(MujocoSimulator, "run", self.run)
        monkeypatch.setattr("tsd_casadi.repetition.learn.record_of", lambda *_: None)

    def run(self, *_: Any, **__: Any) -> Any:
        error = next(self.errors)

        class OfThisError:
            rms_error = error

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
        iterations=2,
        laps=2,
        rule="stable",
        on_learned=lambda _, found: accounts.extend(found),
    )
    # without lag no worse than the plain sum, and right where the model is
    assert runs[2].rms_error < learned.runs[2].rms_error
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
        laps=2,
        first=first,
        on_run=lambda _, remarks: notes.extend(remarks),
    )
    if harm:
        assert runs[0].feedforward.kind == "none"
        assert any("dropped" in note for note in notes)
    else:
        assert runs[0].feedforward.kind == "generalised"
        assert runs[0].rms_error < 0.2 * learned.runs[0].rms_error
        assert notes == []
    assert runs[1].feedforward.kind == "learned"
    # an entry that exists is continued with what it has
    on = learn(simulator, controller, [SQUAT], database, laps=2, first=first)
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
