"""Take the pictures of docs/view.md: the live page in Chromium, with robots that run.

Run: python -m docs.make_screenshots [NAME ...]

Takes some minutes, and Chromium (``apt install chromium``) with the extras 'view' and 'test'.
"""

from __future__ import annotations

import io
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Page

from benchmarks.chromium import address_of, chromium, command
from tsd_server.service_process import ServiceProcess, free_endpoint

HERE = Path(__file__).parent
SIZE = {"width": 1280, "height": 800}
COLORS = 256  # of a picture's palette: half of the bytes, and nobody sees it
PATIENCE = 300_000  # ms
ROBOTS = ("hermes_lower", "talos", "g1")


@contextmanager
def page_with(folder: Path, *robots: str) -> Iterator[Page]:
    """Open the page when it draws some robots."""
    with command(folder, "view") as view, chromium() as browser:
        page = browser.new_page(viewport=SIZE)
        page.set_default_timeout(PATIENCE)
        page.goto(address_of(view))
        # that this browser has no graphics card is nobody's business
        page.locator(".mantine-Notification-closeButton").first.click()
        open_tab(page, "View")
        for robot in robots:
            page.locator(f"[data-drawn~='{robot}']").wait_for(state="attached")
        yield page


def open_tab(page: Page, name: str) -> None:
    """Bring a tab to the front."""
    page.get_by_role("tab", name=name, exact=True).click()
    page.locator("[role=tab][aria-selected=true]", has_text=name).wait_for()


def keep(page: Page, name: str) -> None:
    """Take the picture."""
    page.wait_for_timeout(4000)  # for the charts to fill
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    target = HERE / f"{name}.png"
    picture.quantize(COLORS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
        target, optimize=True
    )
    print(f"{target}: {target.stat().st_size / 1000:.0f} kB")


def robots(folder: Path) -> None:
    """Three robots side by side."""
    squat = ("squat", "--controller", "local", "--laps", "500", "--frequency", "0.4")
    with ExitStack() as stack:
        for robot in ROBOTS:
            options = ("--robot", robot, "--model-error", "0.1")
            stack.enter_context(command(folder, "simulate", *squat, *options))
        page = stack.enter_context(page_with(folder, *ROBOTS))
        open_tab(page, "Motion")
        page.wait_for_function(
            "() => /lap ([4-9]|..)/.test(document.querySelector('[data-run]')?.dataset.run)"
        )
        keep(page, "view_robots")


def learning(folder: Path) -> None:
    """G1 learns to squat: a feedforward takes the feedback's place."""
    endpoint = free_endpoint()
    database = str(folder.parent / "learned.sqlite")
    service = ["learner", "--database", database, "--listen", endpoint]
    options = ("--robot", "g1", "--model-error", "0.1", "--controller", "local", "--laps", "4")
    learn = (
        "learn",
        "squat",
        "--connect",
        endpoint,
        "--iterations",
        "16",
        "--stop-after",
        "16",
        *options,
    )
    with (
        ServiceProcess(service, run_directory=folder),
        ServiceProcess(["controller", "--listen", free_endpoint()], run_directory=folder),
        command(folder, *learn),
        page_with(folder, "g1") as page,
    ):
        page.get_by_label("see through the robot").click()
        open_tab(page, "Motion")
        # each of the later repetitions will do, near its end
        page.wait_for_function(
            "() => /repetition ([3-9]|1.), .*lap [34]/.test("
            "document.querySelector('[data-run]')?.dataset.run)"
        )
        keep(page, "view_learning")


def explorer(folder: Path) -> None:
    """Squats learned at three amplitudes: what is known at others, and how the error shrank."""
    endpoint = free_endpoint()
    database = str(folder.parent / "learned.sqlite")
    service = ["learner", "--database", database, "--listen", endpoint]
    squat = ("squat", "--controller", "local", "--frequency", "0.5", "--model-error", "0.1")
    learn = ("learn", *squat, "--auto", "3", "--region", "amplitude", "--iterations", "2")
    with ServiceProcess(service, run_directory=folder):
        with command(folder, *learn, "--connect", endpoint) as learned:
            learned.wait()
        with (
            command(folder, "simulate", *squat, "--laps", "500"),
            page_with(folder, "hermes_lower") as page,
        ):
            open_tab(page, "Learning")
            keep(page, "view_iterations")
            open_tab(page, "Explorer")
            page.get_by_role("slider").first.focus()
            page.keyboard.press("ArrowRight")
            keep(page, "view_explorer")


PICTURES: dict[str, Any] = {"robots": robots, "learning": learning, "explorer": explorer}


if __name__ == "__main__":
    for wanted in sys.argv[1:] or PICTURES:
        with tempfile.TemporaryDirectory() as kept:
            PICTURES[wanted](Path(kept) / "run")
