"""The report as one HTML page with everything in it."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tsd_experiments.harness.section import Goal, Section, Table
from tsd_experiments.report.circumstances import DIFFERENCES

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


def _html_goals(goals: Sequence[Goal]) -> str:
    if not goals:
        return ""
    rows = "".join(
        f"<tr><td>{html.escape(goal.identifier)}</td><td>{html.escape(goal.goal)}</td>"
        f"<td>{goal.measured_text}</td><td class='{goal.verdict}'>{goal.verdict}</td></tr>"
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
