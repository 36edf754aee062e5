"""Recordings as no robot makes them, of twelve kinds, each from an honest one."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from random import Random
from typing import Any

Document = dict[str, Any]
SIGNALS = ("feedback", "error", "reference")


def abuse(honest: Mapping[str, Any], kind: str, chance: Random) -> Document:
    """Spoil a copy of an honest record.

    Args:
        honest: Fields of a ``RecordMessage`` whose laps have positions.
        kind: Name of one of ``KINDS``.
        chance: How much of it, and where.
    """
    document = copy.deepcopy(dict(honest))
    KINDS[kind](document, chance)
    return document


def _scale(chance: Random, low: float, high: float) -> float:
    return float(math.exp(chance.uniform(math.log(low), math.log(high))))


def _standing_phase(document: Document, chance: Random) -> None:
    for lap in document["laps"]:
        phase = lap["phase"]
        start = chance.randrange(len(phase) - 5)
        stop = start + chance.randint(2, len(phase) - start)
        if chance.random() < 0.5:
            phase[start:stop] = phase[start:stop][::-1]
        else:
            phase[start:stop] = [phase[start]] * (stop - start)


def _part_of_a_lap(document: Document, chance: Random) -> None:
    share = chance.uniform(0.01, 0.95)
    for lap in document["laps"]:
        first = lap["phase"][0]
        if chance.random() < 0.5:  # all samples, squeezed into a part
            lap["phase"] = [first + share * (each - first) for each in lap["phase"]]
        else:
            _cut(lap, max(10, int(share * len(lap["phase"]))), len(lap["phase"]))


def _degrees(document: Document, chance: Random) -> None:
    for lap in document["laps"]:
        lap["phase"] = [math.degrees(each) for each in lap["phase"]]
        if chance.random() < 0.5:
            lap["phase"] = [each % 360 for each in lap["phase"]]


def _gap(document: Document, chance: Random) -> None:
    width = chance.uniform(0.05, 0.9)
    for lap in document["laps"]:
        count = len(lap["phase"])
        start = chance.randrange(max(1, int((1 - width) * count)))
        _cut(lap, start, start + int(width * count))


def _outlier_lap(document: Document, chance: Random) -> None:
    lap = chance.choice(document["laps"])
    factor = _scale(chance, 1.2, 1e4) * chance.choice((-1, 1))
    for name in SIGNALS[: chance.randint(1, 2)]:
        lap[name] = [[factor * each for each in row] for row in lap[name]]


def _disagreeing_laps(document: Document, chance: Random) -> None:
    for lap in document["laps"]:
        size, shift = _scale(chance, 0.1, 1e3), chance.uniform(0, 2 * math.pi)
        for name in SIGNALS[:2]:
            lap[name] = [
                [
                    each + size * math.sin(phase + shift)
                    for each, phase in zip(row, lap["phase"], strict=True)
                ]
                for row in lap[name]
            ]


def _not_a_number(document: Document, chance: Random) -> None:
    value = chance.choice((math.nan, math.inf, -math.inf))
    lap = chance.choice(document["laps"])
    where = chance.choice((*SIGNALS, "phase", "applied", "P", "errors"))
    if where == "phase":
        lap["phase"][chance.randrange(len(lap["phase"]))] = value
    elif where == "applied":
        document["applied"][0][0] = value
    elif where == "P":
        document["circumstances"]["gains"]["P"][0] = value
    elif where == "errors":
        next(iter(document["errors"].values()))["rms"] = value
    else:
        lap[where][0][chance.randrange(len(lap[where][0]))] = value


def _absurd_gains(document: Document, chance: Random) -> None:
    gains = document["circumstances"]["gains"]
    name = chance.choice(("P", "D"))
    factor = chance.choice((-1.0, _scale(chance, 5, 1e8), -_scale(chance, 5, 1e8)))
    gains[name] = [factor * each for each in gains[name]]


def _absurd_parameters(document: Document, chance: Random) -> None:
    name = chance.choice(list(document["parameters"]))
    document["parameters"][name] = chance.choice((-1.0, 1.0)) * _scale(chance, 20, 1e8)


def _too_much(document: Document, chance: Random) -> None:
    L = chance.choice((300, 600, 1000))
    document["basis"] |= {
        "L": L,
        "centres": [2 * math.pi * j / L for j in range(L)],
        "width": 2.5 * L,
    }
    document["applied"] = [[0.0] * L for _ in document["applied"]]
    document["laps"] = document["laps"] * chance.randint(1, 5)


def _other_units(document: Document, chance: Random) -> None:
    factor = chance.choice((math.degrees(1), 1e3, 9.81, _scale(chance, 1.2, 1e6)))
    of = chance.choice((("feedback",), ("error",), ("feedback", "error")))
    for lap in document["laps"]:
        for name in of:
            lap[name] = [[factor * each for each in row] for row in lap[name]]


def _other_sign(document: Document, chance: Random) -> None:
    factor = -_scale(chance, 0.3, 30)
    if chance.random() < 0.5:
        document["applied"] = [
            [each + factor for each in row] for row in document["applied"]
        ]  # as if it had been in use
    for lap in document["laps"]:
        lap["feedback"] = [[factor * each for each in row] for row in lap["feedback"]]


KINDS: dict[str, Callable[[Document, Random], None]] = {
    "phases that stand or go back": _standing_phase,
    "a part of a lap": _part_of_a_lap,
    "degrees for radians": _degrees,
    "a gap": _gap,
    "an outlier lap": _outlier_lap,
    "laps that disagree": _disagreeing_laps,
    "not a number": _not_a_number,
    "absurd gains": _absurd_gains,
    "absurd parameters": _absurd_parameters,
    "too many samples and functions": _too_much,
    "other units": _other_units,
    "another sign": _other_sign,
}


def _cut(lap: Document, start: int, stop: int) -> None:
    lap["phase"] = lap["phase"][:start] + lap["phase"][stop:]
    for name in SIGNALS:
        lap[name] = [row[:start] + row[stop:] for row in lap[name]]
