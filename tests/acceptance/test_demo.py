import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import InvalidValue, SimulationError
from tsd_casadi.motions.ranges import check_motion
from tsd_clients import MujocoSimulator
from tsd_experiments.demo.plan import Plan, file_name
from tsd_experiments.demo.run_demo import run_demo
from tsd_experiments.harness import services
from tsd_server.service_process import ServiceProcess

FIELDS = {
    "label", "motion", "axes", "errors", "amplitude_m", "frequency_hz", "model_error", "p_scale",
    "feedforward", "iteration", "transport", "seed", "rms_error_m", "peak_error_m",
    "ac_rms_error_m", "true_rms_error_m", "mean_abs_feedback", "fell", "ticks", "tick_us",
}  # fmt: skip


def check_summary(out: Path) -> None:
    summary = json.loads((out / "summary.json").read_text())
    assert summary["robot"] == "hermes_lower"
    for run in summary["runs"]:
        assert run.keys() >= FIELDS
        assert run["tick_us"].keys() == {"p50", "p99", "max"}
        assert run["transport"] == "zenoh"
        assert not run["fell"]
    kinds = {run["feedforward"] for run in summary["runs"]}
    assert kinds == {"none", "learned", "constant", "nearest", "generalised"}
    assert summary["ticks_served"] == sum(run["ticks"] for run in summary["runs"])
    logs = sorted((out / "logs").glob("*.npz"))
    assert len(logs) == len(summary["runs"])
    for run in summary["runs"]:
        log = np.load(out / "logs" / f"{file_name(run['label'])}.npz")
        error = log["error"][log["measured"]]
        assert error.shape[1] == len(run["axes"])
        for place, axis in enumerate(run["axes"]):
            rms = np.sqrt(np.mean(error[:, place] ** 2))
            assert rms == pytest.approx(run["errors"][axis]["rms"])
        assert run["errors"]["com.z"]["rms"] == run["rms_error_m"]
    together = [run for run in summary["runs"] if run["label"].endswith("all axes")]
    assert [set(run["axes"]) for run in together] == 3 * [{"com.x", "com.y", "com.z"}]
    others = [run for run in summary["runs"] if run not in together]
    assert all(run["axes"] == ["com.z"] for run in others)
    for figure in ("com_error.png", "feedback.png", "generalization.png"):
        assert (out / figure).stat().st_size > 10_000


@pytest.mark.long
def test_demo_reaches_its_goals(tmp_path: Path) -> None:
    start = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-m", "tsd_cli", "demo", "--out", str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    print(done.stdout)
    print(f"{time.monotonic() - start:.0f} s")
    check_summary(tmp_path)
    runs = {
        run["label"]: run for run in json.loads((tmp_path / "summary.json").read_text())["runs"]
    }
    none, first = runs["3 cm, none"], runs["3 cm, learned, iteration 1"]
    second = runs["3 cm, learned, iteration 2"]
    assert none["rms_error_m"] >= 80 * first["rms_error_m"]
    assert none["ac_rms_error_m"] >= 5 * first["ac_rms_error_m"]
    assert none["ac_rms_error_m"] >= 25 * second["ac_rms_error_m"]
    assert none["mean_abs_feedback"] >= 80 * first["mean_abs_feedback"]
    assert none["rms_error_m"] >= 20 * runs["3 cm, P/5, learned, iteration 1"]["rms_error_m"]
    assert none["ac_rms_error_m"] < 5 * runs["3 cm, constant"]["ac_rms_error_m"]
    generalized = runs["5 cm, generalised"]["ac_rms_error_m"]
    assert generalized <= 1.5 * runs["5 cm, learned, iteration 2"]["ac_rms_error_m"]
    assert generalized <= 0.3 * runs["5 cm, nearest entry as it is"]["ac_rms_error_m"]
    assert runs["3 cm, perfect model, none"]["rms_error_m"] < 2e-6
    together = [runs[f"3 cm, {name}, all axes"] for name in ("none", "learned, iteration 2")]
    for axis in ("com.x", "com.z"):
        before, after = (run["errors"][axis]["rms"] for run in together)
        assert before >= 500 * after


def test_short_demo(tmp_path: Path) -> None:
    plan = Plan(
        frequency=1.0, amplitude=0.01, database=(0.005, 0.012), queried=0.008, nearest=0.005
    )
    run_demo(load_robot("hermes_lower"), tmp_path, plan=plan)
    check_summary(tmp_path)


def test_the_squats_are_those_shares_of_the_robots_range(robot: Robot, mini_biped: Robot) -> None:
    assert Plan.of(robot) == Plan()
    largest = max(Plan.of(mini_biped).database)
    assert Plan.of(mini_biped).amplitude == pytest.approx(largest * 3 / 8, abs=1e-4)
    for squat in Plan.of(mini_biped).squats:
        check_motion(mini_biped, squat)


def test_services_stop_when_a_run_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started = []
    original = services.ServiceProcess

    def remember(arguments: list[str]) -> ServiceProcess:
        started.append(original(arguments))
        return started[-1]

    def fail(*_: object, **__: object) -> None:
        raise SimulationError("on purpose")

    monkeypatch.setattr(services, "ServiceProcess", remember)
    monkeypatch.setattr(MujocoSimulator, "run", fail)
    with pytest.raises(SimulationError, match="on purpose"):
        run_demo(load_robot("hermes_lower"), tmp_path)
    assert len(started) == 2
    assert all(service.process.poll() == 0 for service in started)


def test_robot_that_cannot_do_the_squats_is_told_before_anything_starts(
    mini_biped: Robot, tmp_path: Path
) -> None:
    with pytest.raises(InvalidValue, match=r"amplitude is 0\.06, expected .* for mini_biped"):
        run_demo(mini_biped, tmp_path / "out", plan=Plan())
    assert not (tmp_path / "out").exists()
