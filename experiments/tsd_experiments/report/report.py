"""The report: one HTML page with everything in it, and the page in docs/."""

from __future__ import annotations

import base64
import html
import io
import json
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from matplotlib import pyplot as plt

from tsd_casadi.robot.robot import Robot
from tsd_casadi.version import __version__
from tsd_experiments.harness.run_jobs import cores
from tsd_experiments.harness.section import Goal, Section, Table

PACKAGES = ("casadi", "pin", "mujoco", "numpy", "scipy", "scikit-learn", "eclipse-zenoh")
DIFFERENCES = (
    "The robot is a model of ours with the paper's joints: the Sarcos Hermes is not public. Links, "
    "masses, limits and gains are invented from anthropometric tables; the README of the robot's "
    "folder says where each number comes from.",
    "There is no hydraulic actuation and no real robot. Its stand-in is a simulation with joint "
    "friction, rotor inertia, torque lag and delay, encoder steps and noise, differenced "
    "velocities, and a base pose from joint angles with the feet assumed flat. Every number of it "
    "is an assumption, in the section 'hardware' of the robot file.",
    "The paper prints no measured errors, only 'an order of magnitude' and figures: its claims are "
    "compared in words.",
    "The goals are this project's own. They were set beforehand, from a smaller study with another "
    "model of the robot.",
    "D of the learned task follows P with the damping ratio of the robot file, except where P / 5 "
    "is said: there D stays as it is.",
    "All repetitions of one experiment start in the same random posture and hear the same sensor "
    "noise, unless it says otherwise.",
    "A model error of 10 % means that the controller's masses and inertias are 1.1 times those of "
    "the simulated robot.",
)
STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem }
table { border-collapse: collapse; margin: .5rem 0 }
td, th { padding: .15rem .6rem; text-align: right }
td:first-child, th:first-child { text-align: left } th { border-bottom: 1px solid #888 }
caption { text-align: left; font-style: italic; caption-side: top } img { max-width: 100% }
.met { color: #207040 } .missed { color: #b02020; font-weight: bold }
figcaption { font-style: italic }
blockquote { border-left: 3px solid #bbb; margin-left: 0; padding-left: 1rem; color: #444 }
"""


def save_figures(sections: Sequence[Section], folder: Path) -> dict[str, bytes]:
    """Draw every figure as PNG and SVG.

    Returns:
        The PNG of each by name.
    """
    folder.mkdir(parents=True, exist_ok=True)
    pictures = {}
    for section in sections:
        for figure in section.figures:
            drawn = figure.draw()
            buffer = io.BytesIO()
            drawn.savefig(buffer, dpi=110, format="png")
            drawn.savefig(folder / f"{figure.name}.svg")
            plt.close(drawn)
            pictures[figure.name] = buffer.getvalue()
            (folder / f"{figure.name}.png").write_bytes(pictures[figure.name])
    return pictures


def circumstances(robot: Robot, quick: bool) -> dict[str, Any]:
    """What the numbers were made with, plain data."""
    description = robot.description
    return {
        "tsd_casadi": __version__,
        **{name: version(name) for name in PACKAGES},
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "cores": cores(),
        "robot": robot.name,
        "robot_fingerprint": robot.fingerprint,
        "tasks": [task.model_dump(exclude={"type", "frame"}) for task in description.tasks],
        "hardware": None if description.hardware is None else description.hardware.model_dump(),
        "seed": "0 for starting posture and sensor noise; other seeds are named in the tables",
        "form": "quick" if quick else "full",
    }


def write_html(
    sections: Sequence[Section],
    goals: Sequence[Goal],
    pictures: dict[str, bytes],
    movie: bytes | None,
    made_with: dict[str, Any],
    path: Path,
) -> None:
    """Write the report, pictures included.

    Args:
        pictures: PNG by name.
        made_with: From ``circumstances``.
    """
    parts = [
        "<!doctype html><html lang='en'><meta charset='utf-8'>",
        f"<title>Reproduction</title><style>{STYLE}</style>",
        "<h1>Learning task-specific dynamics to improve whole-body control: reproduction</h1>",
        "<h2>Goals</h2>",
        _html_goals(goals),
        "<h2>What differs from the paper</h2><ul>",
        *(f"<li>{html.escape(text)}</li>" for text in DIFFERENCES),
        "</ul>",
    ]
    for section in sections:
        parts.append(f"<h2>{html.escape(section.title)}</h2>")
        parts.append(f"<blockquote>{html.escape(section.claim)}</blockquote>")
        parts += [f"<p>{html.escape(text)}</p>" for text in section.found]
        for figure in section.figures:
            parts.append(_html_picture(pictures[figure.name], "png", figure.caption))
        parts += [_html_table(table) for table in section.tables]
        parts.append(_html_goals(section.goals))
    if movie is not None:
        parts.append(_html_picture(movie, "gif", "One squat."))
    parts.append(
        "<h2>Made with</h2><pre>" + html.escape(json.dumps(made_with, indent=2)) + "</pre>"
    )
    path.write_text("\n".join(parts))


def write_page(
    sections: Sequence[Section],
    goals: Sequence[Goal],
    made_with: dict[str, Any],
    figures: str,
    path: Path,
) -> None:
    """Write the report as Markdown.

    Args:
        made_with: From ``circumstances``.
        figures: Folder of the pictures as the page names it.
    """
    lines = [
        "# The paper, reproduced and then exceeded",
        "",
        "Generated by `tsd reproduce --page docs/paper.md`; do not edit. Every measured number on "
        "this page was computed from the data which that command wrote.",
        "",
        *_markdown_goals(goals),
        "## What differs from the paper",
        "",
        *(f"- {text}" for text in DIFFERENCES),
        "",
    ]
    for section in sections:
        lines += [f"## {section.title}", "", f"> {section.claim}", ""]
        for text in section.found:
            lines += [text, ""]
        for figure in section.figures:
            lines += [f"![{figure.caption}]({figures}/{figure.name}.png)", ""]
        for table in section.tables:
            lines += _markdown_table(table)
    lines += ["## Made with", "", "```json", json.dumps(made_with, indent=2), "```", ""]
    path.write_text("\n".join(lines))


def _html_goals(goals: Sequence[Goal]) -> str:
    if not goals:
        return ""
    rows = "".join(
        f"<tr><td>{html.escape(goal.identifier)}</td><td>{html.escape(goal.goal)}</td>"
        f"<td>{_measured(goal)}</td><td class='{_verdict(goal)}'>{_verdict(goal)}</td></tr>"
        for goal in goals
    )
    return f"<table><tr><th>comparison<th>goal<th>measured<th></tr>{rows}</table>"


def _html_table(table: Table) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in table.head)
    rows = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>"
        for row in table.rows
    )
    return f"<table><caption>{html.escape(table.caption)}</caption><tr>{head}</tr>{rows}</table>"


def _html_picture(picture: bytes, kind: str, caption: str) -> str:
    data = base64.b64encode(picture).decode()
    return (
        f"<figure><img alt='' src='data:image/{kind};base64,{data}'>"
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
    )


def _markdown_goals(goals: Sequence[Goal]) -> list[str]:
    rows = [[goal.identifier, goal.goal, _measured(goal), _verdict(goal)] for goal in goals]
    return _markdown_table(Table("", ["comparison", "goal", "measured", ""], rows))


def _markdown_table(table: Table) -> list[str]:
    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"

    rule = line(["---", *["---:"] * (len(table.head) - 1)])
    caption = [f"*{table.caption}*", ""] if table.caption else []
    return [*caption, line(table.head), rule, *(line(row) for row in table.rows), ""]


def _measured(goal: Goal) -> str:
    return "–" if goal.measured is None else f"{goal.measured:.4g}"


def _verdict(goal: Goal) -> str:
    return {True: "met", False: "missed", None: "not covered"}[goal.met]
