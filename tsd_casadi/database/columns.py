"""Entries, events and iterations as columns of their rows."""

from __future__ import annotations

import json
from dataclasses import asdict, is_dataclass
from typing import Any

from tsd_casadi.database.rows import EventKind
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.state import Matrix


def entry_columns(entry: Entry) -> dict[str, Any]:
    """Write down what an entry is for."""
    return {
        "id": entry.identifier,
        "robot": entry.key.robot,
        "motion": entry.key.motion,
        "version": entry.key.version,
        "axes": encode(entry.key.axes),
        "parameters": encode(dict(entry.key.parameters)),
        "basis_kind": "periodic",
        "basis": encode({"L": entry.basis.L, "width": entry.basis.width}),
    }


def event_columns(entry: Entry, event: int, kind: EventKind) -> dict[str, Any]:
    """Write down how an entry is after an event."""
    return {
        "id": event,
        "entry": entry.identifier,
        "kind": kind,
        "time": entry.updated,
        "body": entry.key.context.body,
        "formulation": entry.key.context.formulation,
        "correction": entry.key.context.correction,
        "declaration": encode(entry.declaration),
        "circumstances": encode(entry.circumstances),
        "rule": entry.rule.name,
        "learning_gain": float(entry.learning_gain),
    }


def iteration_columns(entry: int, event: int, iteration: Iteration) -> dict[str, Any]:
    """Write down how an iteration is after an event."""
    errors = iteration.errors
    return {
        "entry": entry,
        "number": iteration.number,
        "event": event,
        "learned_from": iteration.learned_from,
        "epoch": iteration.epoch,
        "weights": encode(iteration.weights.tolist()),
        "uncertainty": _rows(iteration.uncertainty),
        "errors": None
        if errors is None
        else encode({axis: error.plain() for axis, error in errors.items()}),
        "circumstances": encode(iteration.circumstances),
        "feedback": _rows(iteration.feedback),
        "error_weights": _rows(iteration.error_weights),
        "reference_weights": _rows(iteration.reference_weights),
    }


def encode(value: Any) -> Any:
    """Write plain data or a dataclass of it as JSON; None stays None.

    Raises:
        ValueError: If a number is not finite, or it is no plain data.
    """
    if value is None:
        return None
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    return json.dumps(value, allow_nan=False)


def _rows(weights: Matrix | None) -> Any:
    return None if weights is None else encode(weights.tolist())
