"""The live page as its users see it: 'tsd' beside a Chromium that needs no graphics card."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser

CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
ARGUMENTS = (
    *("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"),
    *("--enable-unsafe-swiftshader", "--disable-dev-shm-usage"),
)


@contextmanager
def command(folder: Path, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Run 'tsd' until the end of the block.

    Args:
        folder: Its run directory.
    """
    process = subprocess.Popen(
        [sys.executable, "-m", "tsd_cli", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "TSD_RUN_DIR": str(folder), "PYTHONUNBUFFERED": "1"},
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def address_of(view: subprocess.Popen[str]) -> str:
    """Wait until 'tsd view' says where its page is."""
    assert view.stdout is not None
    for line in view.stdout:
        if found := re.search(r"http://\S+:\d+", line):
            return found.group()
    raise RuntimeError("tsd view ended before it had a page")


@contextmanager
def chromium() -> Iterator[Browser]:
    """Open Chromium without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[*ARGUMENTS])
        try:
            yield browser
        finally:
            browser.close()
