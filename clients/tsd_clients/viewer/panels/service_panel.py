"""How the services are."""

from __future__ import annotations

from html import escape

import viser

from tsd_casadi.wire.health import AnswersMessage, HealthMessage
from tsd_clients.viewer.panel import Panel
from tsd_clients.viewer.service_watch import ServiceWatch, WatchedService

NOTHING = (
    "<p>No service of yours runs here. <code>tsd controller</code> and <code>tsd learner</code> "
    "start one; this page finds them by itself.</p>"
)
GOOD, BAD, UNKNOWN = "#2b8a3e", "#c92a2a", "#868e96"


class ServicePanel(Panel):
    """A card for each service; one that is gone stays, in red, until it is back."""

    title = "Services"

    def __init__(self, watch: ServiceWatch) -> None:
        """Show what is watched."""
        self._watch = watch

    def build(self, server: viser.ViserServer) -> None:
        """Add the cards."""
        self._cards = server.gui.add_html(NOTHING)

    def update(self, now: float) -> None:
        """Write the cards anew where something changed."""
        cards = "".join(_card(service, now) for service in self._watch.services) or NOTHING
        if cards != self._cards.content:
            self._cards.content = cards


def _card(service: WatchedService, now: float) -> str:
    record, health = service.record, service.health
    robot = "every robot" if record.robot == "*" else record.robot
    color, state = GOOD, ""
    if service.lost is not None:
        color, state = BAD, f"lost {now - service.lost:.0f} s ago"
    elif health is not None:
        state = f"up {duration(health.uptime)}"
    else:
        color, state = (BAD, service.trouble) if service.trouble else (UNKNOWN, "asked")
    rows = [("process", str(record.pid)), ("endpoint", ", ".join(record.endpoints))]
    if health is not None and service.lost is None:
        rows += _rows(health)
    table = "".join(
        f"<tr><td style='color:#868e96;padding-right:1em;vertical-align:top'>{escape(name)}</td>"
        f"<td>{escape(text)}</td></tr>"
        for name, text in rows
    )
    return (
        f"<div data-service='{escape(record.role)}' data-state='{_word(service)}' "
        f"style='border-left:4px solid {color};padding:2px 10px;margin:6px 8px 12px;"
        "font-size:13px'>"
        f"<b>{escape(record.role)}</b> of {escape(robot)} "
        f"<span style='color:{color};font-weight:600'>{escape(state)}</span>"
        f"<table style='margin-top:4px;font-size:12px'>{table}</table></div>"
    )


def _word(service: WatchedService) -> str:
    if service.lost is not None:
        return "lost"
    return "silent" if service.health is None else "answers"


def _rows(health: HealthMessage) -> list[tuple[str, str]]:
    rows = [("version", health.versions.get("tsd_casadi", "?"))]
    if health.ticks is not None:
        failed = {name: count for name, count in health.ticks.items() if name != "ok"}
        told = ", ".join(f"{name} {count}" for name, count in sorted(failed.items())) or "none"
        rows += [("ticks", f"{health.ticks.get('ok', 0)} solved"), ("failures", told)]
    if health.database is not None:
        database = health.database
        rows.append(
            (
                "database",
                f"{database.entries} entries, {database.damaged} damaged, "
                f"{database.size / 1e6:.1f} MB",
            )
        )
    rows += [(name, _answered(answers)) for name, answers in health.answers.items()]
    return rows


def _answered(answers: AnswersMessage) -> str:
    parts = [f"{answers.answered} answered"]
    for word, counts in (("refused", answers.refused), ("failed", answers.failed)):
        if counts:
            parts.append(f"{word} {sum(counts.values())} ({', '.join(sorted(counts))})")
    slow = answers.latency.quantile(0.99)
    if slow is not None:
        parts.append(f"99 % within {slow / 1000:.3g} ms")
    return ", ".join(parts)


def duration(seconds: float) -> str:
    """Say how long something took, in the unit that suits it."""
    minutes, hours, days = seconds / 60, seconds / 3600, seconds / 86400
    if days >= 1:
        return f"{days:.1f} d"
    if hours >= 1:
        return f"{hours:.1f} h"
    return f"{minutes:.0f} min" if minutes >= 1 else f"{seconds:.0f} s"
