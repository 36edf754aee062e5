from __future__ import annotations

import sys
import time
from dataclasses import replace
from typing import Any

import pytest

import tsd_models
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.context import Context
from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER
from tsd_cli import command_line
from tsd_clients.viewer.child_run import ChildRun
from tsd_clients.viewer.known_motion import KnownMotion
from tsd_clients.viewer.run_wish import LARGEST_MODEL_ERROR, MOST_ITERATIONS, RunWish

ROBOTS = {name: str(path) for name, path in tsd_models.robot_files().items()}
SQUAT = KnownMotion("hermes_lower", "squat", "1", ("com.x", "com.z"), Context("0", "1"), ())
WISH = RunWish("learn", SQUAT, {"amplitude": 0.04, "frequency": 0.25, "height": 0.0}, 0.1)


def test_every_value_is_a_word_of_its_own() -> None:
    words = WISH.arguments(ROBOTS, [CONTROLLER, LEARNER])
    assert words[:2] == ["learn", "squat"]
    pairs = dict(zip(words[2::2], words[3::2], strict=False))
    assert pairs["--robot"] == ROBOTS["hermes_lower"]
    assert pairs["--amplitude"] == "0.04" and pairs["--axes"] == "com.x,com.z"
    assert pairs["--iterations"] == "2" and pairs["--model-error"] == "0.1"
    assert words[-4:] == ["--connect", CONTROLLER, "--connect", LEARNER]
    simulated = replace(WISH, command="simulate", in_real_time=False)
    alone = simulated.arguments(ROBOTS, [LEARNER])
    assert alone[-4:] == ["--connect", LEARNER, "--controller", "local"]
    assert "--feedforward" in alone and "--pace" not in alone and "--iterations" not in alone


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    with pytest.raises(SystemExit) as ended:
        command_line.run(words)
    assert ended.value.code == 1
    return capsys.readouterr().err


@pytest.mark.parametrize("command", ["simulate", "learn"])
def test_the_command_line_knows_every_word(
    command: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    words = replace(WISH, command=command).arguments(ROBOTS, [CONTROLLER, LEARNER])
    # usage that it does not know ends with 2; here it comes as far as the endpoint
    assert "nowhere" in refused(capsys, *words[:-4], "--connect", "nowhere")


def of(**changes: Any) -> RunWish:
    return replace(WISH, known=replace(SQUAT, **changes))


@pytest.mark.parametrize(
    ("wish", "word"),
    [
        (of(motion="evil.py:Bounce"), "motion"),
        (of(motion="--help"), "motion"),
        (of(motion="wave.csv"), "motion"),
        (of(robot="/tmp/evil.yaml"), "robot"),
        (of(axes=("com.z;rm -rf",)), "axis"),
        (of(axes=("--controller",)), "axis"),
        (replace(WISH, command="controller"), "command"),  # type: ignore[arg-type]
        (replace(WISH, parameters={"amplitude": 0.04}), "parameters"),
        (replace(WISH, parameters={**WISH.parameters, "log": 1.0}), "parameters"),
        (replace(WISH, parameters={**WISH.parameters, "amplitude": float("nan")}), "amplitude"),
        (replace(WISH, model_error=LARGEST_MODEL_ERROR * 1.001), "model error"),
        (replace(WISH, model_error=-0.001), "model error"),
        (replace(WISH, feedforward="; ls"), "feedforward"),
        (replace(WISH, iterations=MOST_ITERATIONS + 1), "iterations"),
        (replace(WISH, iterations=0), "iterations"),
    ],
)
def test_what_a_page_cannot_ask_for_is_refused(wish: RunWish, word: str) -> None:
    with pytest.raises(InvalidValue, match=word):
        wish.arguments(ROBOTS, [CONTROLLER, LEARNER])


def test_at_the_ends_of_what_can_be_asked_for_it_is_done() -> None:
    wish = replace(WISH, iterations=MOST_ITERATIONS, model_error=LARGEST_MODEL_ERROR)
    assert wish.arguments(ROBOTS, [LEARNER])
    with pytest.raises(InvalidValue):
        wish.arguments(ROBOTS, ["--listen"])


def finished(run: ChildRun) -> ChildRun:
    end = time.monotonic() + 30
    while run.code is None:
        assert time.monotonic() < end
        run.poll()
        time.sleep(0.01)
    run.close()
    return run


def test_a_child_tells_what_it_prints_and_how_it_ended() -> None:
    code = "import sys; print('one'); print('two', file=sys.stderr); sys.exit(3)"
    run = finished(ChildRun([sys.executable, "-c", code]))
    assert run.code == 3
    assert sorted(run.output.splitlines()) == ["one", "two"]


def test_a_child_is_asked_to_stop_as_by_a_key() -> None:
    code = (
        "import time\n"
        "print('here', flush=True)\n"
        "try:\n    time.sleep(60)\nexcept KeyboardInterrupt:\n    print('kept')"
    )
    run = ChildRun([sys.executable, "-c", code])
    end = time.monotonic() + 30
    while not run.output:
        assert time.monotonic() < end
        time.sleep(0.01)
    run.stop()
    assert finished(run).output.splitlines() == ["here", "kept"]


def test_a_page_that_others_reach_runs_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(capsys, "view", "--allow-run", "--host", "192.0.2.1")
    assert "without a password" in said
