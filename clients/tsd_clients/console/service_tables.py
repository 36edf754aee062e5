"""Tables of services and how they are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rich.markup import escape

from tsd_casadi.wire.health import AnswersMessage, HealthMessage
from tsd_casadi.wire.run_directory import is_stopped
from tsd_casadi.wire.run_record import RunRecord
from tsd_clients.console.table import Column, console, print_table
from tsd_clients.remote.service_health import ServiceState


def print_services(services: Sequence[ServiceState]) -> None:
    """Print services, one per row, and below what they answered by key."""
    if not services:
        console.print("no service of yours runs here; 'tsd controller' and 'tsd learner' start one")
        return
    columns = [
        Column("service", [_role(state) for state in services], is_text=True),
        Column("robot", [_robot(state) for state in services], is_text=True),
        Column("endpoint", [escape(", ".join(each.endpoints)) for each in services], is_text=True),
        Column("since", [_since(state) for state in services], rank=3, is_text=True),
        Column("process", [_process(state) for state in services], rank=4),
        Column("state", [_state(state) for state in services], rank=1, is_text=True),
    ]
    print_table("", columns)
    for state in services:
        if state.trouble:
            console.print(escape(f"{', '.join(state.endpoints)}: {state.trouble}"), highlight=False)
    answers = [
        (state.health, name, answer)
        for state in services
        if state.health is not None
        for name, answer in state.health.answers.items()
    ]
    if answers:
        _print_answers(answers)
    for state in services:
        if state.health is not None and state.health.database is not None:
            database = state.health.database
            console.print(
                escape(
                    f"{database.path}: {database.entries} entries, {database.damaged} damaged, "
                    f"{database.size / 1e6:.1f} MB, last written {database.last_write or 'never'}"
                ),
                highlight=False,
            )


def print_runs_here(runs: Sequence[RunRecord]) -> None:
    """Print runs that can be watched, one per row; nothing without any."""
    if not runs:
        return
    columns = [
        Column("run", [escape(run.motion or "") for run in runs], is_text=True),
        Column("robot", [escape(run.robot) for run in runs], is_text=True),
        Column("endpoint", [escape(run.telemetry or "") for run in runs], is_text=True),
        Column("since", [run.started.replace("+00:00", "Z") for run in runs], rank=3, is_text=True),
        Column("process", [str(run.pid) for run in runs], rank=4),
        Column(
            "state",
            ["frozen" if is_stopped(run.pid) else "under way" for run in runs],
            rank=1,
            is_text=True,
        ),
    ]
    print_table("", columns)


def _print_answers(answers: Sequence[tuple[HealthMessage, str, AnswersMessage]]) -> None:
    columns = [
        Column("key", [f"{health.role}/{name}" for health, name, _ in answers], is_text=True),
        Column("answered", [str(each.answered) for _, _, each in answers]),
        Column("refused", [_kinds(each.refused) for _, _, each in answers]),
        Column("failed", [_kinds(each.failed) for _, _, each in answers]),
        Column("waiting", [str(each.waiting) for _, _, each in answers], rank=2),
        Column("median\nms", [_quantile(each, 0.5) for _, _, each in answers], rank=1),
        Column("99 %\nms", [_quantile(each, 0.99) for _, _, each in answers], rank=1),
        Column("slowest\nms", [_quantile(each, 1.0) for _, _, each in answers], rank=3),
    ]
    print_table("answers, with the time from taking up the query, at most", columns)
    unsolved: Counter[str] = Counter()
    for health in {health.instance: health for health, _, _ in answers}.values():
        unsolved.update({name: n for name, n in (health.ticks or {}).items() if name != "ok"})
    if unsolved:
        console.print(f"ticks with the safe torque: {_kinds(unsolved)}", highlight=False)


def _role(state: ServiceState) -> str:
    known = state.health or state.record
    return "?" if known is None else known.role


def _robot(state: ServiceState) -> str:
    known = state.health or state.record
    return "?" if known is None else "every" if known.robot == "*" else escape(known.robot)


def _since(state: ServiceState) -> str:
    known = state.health or state.record
    return "" if known is None else known.started.replace("+00:00", "Z")


def _process(state: ServiceState) -> str:
    known = state.health or state.record
    return "" if known is None else str(known.pid)


def _state(state: ServiceState) -> str:
    if state.health is not None:
        return f"answers, up {_duration(state.health.uptime)}"
    return "frozen" if state.trouble.startswith("frozen") else "silent"


def _duration(seconds: float) -> str:
    minutes, hours, days = seconds / 60, seconds / 3600, seconds / 86400
    if days >= 1:
        return f"{days:.1f} d"
    if hours >= 1:
        return f"{hours:.1f} h"
    return f"{minutes:.0f} min" if minutes >= 1 else f"{seconds:.0f} s"


def _kinds(counts: dict[str, int]) -> str:
    return ", ".join(f"{name} {count}" for name, count in sorted(counts.items())) or "0"


def _quantile(answers: AnswersMessage, share: float) -> str:
    bound = answers.latency.quantile(share)
    return "" if bound is None else f"{bound / 1000:.3g}"
