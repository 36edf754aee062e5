"""The live page in a browser: what moves, what is lost, what comes back."""

from __future__ import annotations

import io
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tsd_casadi as tsd
from benchmarks.chromium import CHROMIUM, address_of, chromium, command
from benchmarks.learned_squats import AXES, FREQUENCY, ROBOT, learn_squats
from tsd_casadi.wire.run_directory import running
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_clients.viewer.prediction import PHASE
from tsd_server.service_process import ServiceProcess, free_endpoint

SIZE = {"width": 900, "height": 600}
# left of the panel, below the note about drawing without a graphics card
VIEW = {"x": 0, "y": 160, "width": 440, "height": 440}
# of a step in the browser, on a busy machine [ms]
PATIENCE = 60_000
JOINT = "R_KFE"
ANGLE = f"[data-angle='{JOINT}']"

# what a chart draws is in the properties of the component around it
DRAWN = """title => {
  for (const chart of document.querySelectorAll('.uplot')) {
    let node = chart, key;
    while (node && !(key = Object.keys(node).find(k => k.startsWith('__reactFiber'))))
      node = node.parentElement;
    for (let fiber = node && node[key]; fiber; fiber = fiber.return) {
      const drawn = fiber.memoizedProps;
      if (!drawn || !drawn.data || !drawn.options) continue;
      if (drawn.options.title !== title) break;
      const lines = drawn.options.series.map(each => each.label);
      return Array.from(drawn.data[lines.indexOf('answer')] || []);
    }
  }
  return [];
}"""

pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium: 'apt install chromium' brings it"),
    pytest.mark.long,
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("page") / "run"


@pytest.fixture(scope="module")
def learner(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServiceProcess]:
    database = tmp_path_factory.mktemp("page") / "learned.sqlite"
    learn_squats(database)
    arguments = ["learner", "--database", str(database), "--listen", free_endpoint()]
    with ServiceProcess(arguments, run_directory=folder) as service:
        yield service


@pytest.fixture(scope="module")
def address(folder: Path) -> Iterator[str]:
    """Address of the page."""
    with command(folder, "view", "--port", free_endpoint().rpartition(":")[2]) as process:
        address = address_of(process)
        assert address.startswith("http://127.0.0.1:")
        yield address


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as opened:
        yield opened


@pytest.fixture(scope="module")
def page(address: str, browser: Any) -> Iterator[Any]:
    """The page, open; never loaded anew."""
    opened = browser.new_page(viewport=SIZE)
    opened.set_default_timeout(PATIENCE)
    # viser asks nobody outside, and neither do we
    opened.route(
        "**/*",
        lambda route: route.continue_() if route.request.url.startswith(address) else route.abort(),
    )
    opened.goto(address)
    opened.locator("canvas").first.wait_for()
    yield opened
    opened.close()


def pixels(page: Any) -> np.ndarray[Any, Any]:
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(page.screenshot(clip=VIEW))).convert("RGB"), dtype=int)


def open_tab(page: Any, name: str) -> None:
    tab = page.get_by_role("tab", name=name, exact=True)
    tab.click()
    page.locator("[role=tab][aria-selected=true]", has_text=name).wait_for()


def wait_for_service(page: Any, role: str, state: str) -> None:
    page.locator(f"[data-service='{role}'][data-state='{state}']").wait_for()


def test_robot_moves_and_a_service_that_is_gone_is_told(
    page: Any, folder: Path, learner: ServiceProcess, controller: tsd.Controller
) -> None:
    arguments = ["controller", "--listen", free_endpoint()]
    with command(
        folder, "simulate", "squat", "--controller", "local", "--frequency", "0.5", "--laps", "999"
    ):
        with ServiceProcess(arguments, run_directory=folder) as service:
            page.locator("[data-run^='running']").wait_for()
            open_tab(page, "Joints")
            page.locator(ANGLE).wait_for()
            angle = page.locator(ANGLE).inner_text()
            page.wait_for_function(
                "([where, before]) => document.querySelector(where).innerText !== before",
                arg=[ANGLE, angle],
            )
            open_tab(page, "View")
            page.locator("[data-drawn='hermes_lower']").wait_for(state="attached")
            before = pixels(page)
            # shins and thighs, dark on light; a line or two would be some hundred pixels
            assert moved(page, before) > 500

            open_tab(page, "Services")
            wait_for_service(page, "controller", "answers")
            wait_for_service(page, "learner", "answers")
            service.process.kill()
            wait_for_service(page, "controller", "lost")
            wait_for_service(page, "learner", "answers")
        with ServiceProcess(arguments, run_directory=folder):
            wait_for_service(page, "controller", "answers")


def moved(page: Any, before: np.ndarray[Any, Any], tries: int = 40) -> int:
    """Count pixels that are another colour in a later picture, in the one where most are."""
    most = 0
    for _ in range(tries):
        changed = np.abs(pixels(page) - before).max(axis=2) > 40
        most = max(most, int(changed.sum()))
        if most > 500:
            break
    return most


def test_slider_shows_what_the_learner_answers(
    page: Any, folder: Path, learner: ServiceProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    open_tab(page, "Explorer")
    page.locator("[data-answer='generalised']").wait_for()
    slider = page.get_by_role("slider").first
    slider.focus()
    before = drawn(page, "com.z")
    for _ in range(17):
        page.keyboard.press("ArrowLeft")
    amplitude = float(slider.get_attribute("aria-valuenow"))
    assert amplitude == pytest.approx(0.053)
    monkeypatch.setenv("TSD_RUN_DIR", str(folder))
    (endpoint,) = (record.endpoints[0] for record in running() if record.role == "learner")
    with RemoteLearner([endpoint]) as remote:
        answer = remote.query("squat", robot=ROBOT, amplitude=amplitude, frequency=FREQUENCY)
    for axis, wanted in zip(AXES, answer.mean(PHASE), strict=True):
        assert_drawn(page, axis, wanted)
    # it was another one before
    assert np.abs(answer.mean(PHASE)[AXES.index("com.z")] - before).max() > 0.02

    page.keyboard.press("End")
    refused = page.locator("[data-answer='refused']")
    refused.wait_for()
    assert "outside the learned range 0.02 to 0.08 m" in refused.inner_text()
    assert len(drawn(page, "com.z")) == 0
    # by key: no hint that pops up lies over it
    page.get_by_label("Extrapolate").focus()
    page.keyboard.press("Space")
    page.locator("[data-answer='generalised']").wait_for()


def drawn(page: Any, axis: str) -> np.ndarray[Any, Any]:
    """Numbers of the answer in the chart of an axis; none where it is refused."""
    return np.array(page.evaluate(DRAWN, f"Feedforward along {axis}"))


def assert_drawn(page: Any, axis: str, wanted: np.ndarray[Any, Any]) -> None:
    """Wait until it is."""
    end = time.monotonic() + PATIENCE / 1000
    while True:
        there = drawn(page, axis)
        if there.shape == wanted.shape and np.abs(there - wanted).max() < 1e-9:
            return
        assert time.monotonic() < end, (axis, there, wanted)
        page.wait_for_timeout(50)


def test_errors_of_iterations_are_told(page: Any, learner: ServiceProcess) -> None:
    open_tab(page, "Learning")
    page.get_by_text("RMS error", exact=True).wait_for()
    page.get_by_text("rule guarded").wait_for()
