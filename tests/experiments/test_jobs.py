from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import SimulationError, TsdError
from tsd_experiments.harness.experiment import Done, Experiment
from tsd_experiments.harness.job import Job, Result
from tsd_experiments.harness.learn_case import learn_case
from tsd_experiments.harness.outcome import Outcome
from tsd_experiments.harness.replay_case import replay_case
from tsd_experiments.harness.run_jobs import run_jobs
from tsd_experiments.harness.section import Section
from tsd_experiments.harness.store import Store
from tsd_experiments.reproduce import run_all

SPAN = (1000.0, 1002.5)
# what is run tells that it was
REFUSED = {"case": {"amplitude": -1.0, "hardware": []}}


@pytest.fixture
def store(robot: Robot, tmp_path: Path) -> Store:
    return Store(tmp_path / "data", robot)


@pytest.fixture
def outcome() -> Outcome:
    return Outcome([{"label": "replay", "rms_error_m": 0.25}], {"replay/weights": np.ones((1, 3))})


def test_saved_outcome_is_loaded_as_it_was(store: Store, outcome: Outcome) -> None:
    job = Job("one", replay_case, {"case": {"amplitude": 0.03}})
    store.save(job, outcome, SPAN)
    result = store.load(job)
    assert result is not None
    assert result.row("replay")["rms_error_m"] == 0.25
    assert result.weights("replay") == [1.0, 1.0, 1.0]
    np.testing.assert_array_equal(result.errors(), [0.25])
    assert result.span == SPAN


@pytest.mark.parametrize(
    "other",
    [
        Job("one", replay_case, {"case": {"amplitude": 0.04}}),
        Job("one", learn_case, {"case": {"amplitude": 0.03}}),
        Job("one", replay_case, {"case": {"amplitude": 0.03}}, over_network=True),
        Job("two", replay_case, {"case": {"amplitude": 0.03}}),
    ],
)
def test_results_of_other_jobs_are_not_taken(store: Store, outcome: Outcome, other: Job) -> None:
    store.save(Job("one", replay_case, {"case": {"amplitude": 0.03}}), outcome, SPAN)
    assert store.load(other) is None


@pytest.mark.parametrize("suffix", ["json", "npz"])
@pytest.mark.parametrize("damage", ["missing", "cut"])
def test_damaged_results_are_done_again(
    store: Store, outcome: Outcome, suffix: str, damage: str
) -> None:
    job = Job("one", replay_case)
    store.save(job, outcome, SPAN)
    path = store.folder / f"one.{suffix}"
    content = path.read_bytes()
    path.unlink()
    if damage == "cut":
        path.write_bytes(content[: len(content) // 2])
    assert store.load(job) is None


def test_finished_jobs_are_not_run_again(store: Store, outcome: Outcome) -> None:
    class Stages(Experiment):
        name = "stages"

        def jobs(self, done: Done) -> list[Job]:
            first, second = (Job(name, replay_case, REFUSED) for name in ("one", "two"))
            return [first, second] if "one" in done else [first]

        def report(self, done: Done) -> Section:
            return Section("stages", "the second is named once the first is done")

    experiment = Stages(quick=True)
    for name in ("one", "two"):
        store.save(Job(name, replay_case, REFUSED), outcome, SPAN)
    done = run_all([experiment], store)
    assert done.keys() == {"one", "two"}
    assert done["two"].row("replay")["rms_error_m"] == 0.25
    (store.folder / "two.json").unlink()
    with pytest.raises(TsdError, match="amplitude"):
        run_all([experiment], store)


def test_a_job_runs_in_a_process_of_its_own_and_is_kept(store: Store) -> None:
    case = {"amplitude": 0.01, "frequency": 1.0, "laps": 2, "hardware": []}
    job = Job("replay", replay_case, {"case": case, "weights": None, "kind": "none"}, cost=3.0)
    seen: list[tuple[float, float]] = []
    results = run_jobs([job], store, lambda done, total: seen.append((done, total)))
    row: dict[str, Any] = results["replay"].row("replay")
    assert row["amplitude_m"] == 0.01 and not row["fell"]
    error = results["replay"].arrays["replay/error"]
    # the trace keeps every tenth tick of the run
    assert len(error) == -(-row["ticks"] // 10)
    assert seen == [(0.0, 3.0), (3.0, 3.0)]
    stored = json.loads((store.folder / "replay.json").read_text())
    assert stored["arguments"]["case"] == case
    kept = store.load(job)
    assert kept is not None and kept.span == results["replay"].span
    begin, end = kept.span
    assert 0.0 < end - begin < 600.0


def test_errors_of_a_job_are_told(store: Store) -> None:
    job = Job("broken", replay_case, REFUSED)
    with pytest.raises(TsdError, match="amplitude"):
        run_jobs([job], store, lambda done, total: None)
    assert store.load(job) is None


def test_a_folder_that_cannot_be_made_is_refused(robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(TsdError, match="--out"):
        Store(tmp_path / "file" / "data", robot)


def test_older_arrays_are_never_found_beside_newer_descriptions(
    store: Store, outcome: Outcome, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = Job("one", replay_case)
    store.save(job, outcome, SPAN)

    def full(*_: Any, **__: Any) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(OSError, match="no space"):
        store.save(job, outcome, SPAN)
    assert store.load(job) is None


def test_the_last_iteration_is_not_the_stop() -> None:
    rows = [{"label": "iteration 0"}, {"label": "iteration 1"}, {"label": "stopped"}]
    assert Result(rows, {}, SPAN).last_iteration() == "iteration 1"
    with pytest.raises(SimulationError, match="it fell"):
        Result([{"label": "stopped", "stopped": "it fell"}], {}, SPAN).last_iteration()


def test_another_scene_is_another_job(write_robot: Callable[..., Path]) -> None:
    robot = load_robot(write_robot())
    job = Job("one", replay_case)
    before = job.fingerprint(robot)
    scene = next(robot.path.parent.glob("*.xml"))
    scene.write_text(scene.read_text() + "<!-- harder ground -->")
    assert job.fingerprint(load_robot(robot.path)) != before
