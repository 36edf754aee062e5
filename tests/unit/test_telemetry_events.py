from __future__ import annotations

import pytest

from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.wire.telemetry import (
    AnyEvent,
    LapDone,
    RepetitionEnded,
    RunOver,
    RunStory,
    decode_event,
)
from tsd_clients.telemetry.kept_events import MOST_LAPS, KeptEvents


def lap(number: int, repetition: int = 1) -> LapDone:
    nothing = {"com.z": 0.0}
    return LapDone(
        number=number,
        repetition=repetition,
        lap=number,
        rms=nothing,
        ac_rms=nothing,
        mean_abs_feedback=nothing,
    )


def began(number: int, repetition: int) -> bytes:
    """As much of it as is looked at by who keeps it."""
    text = f'"event":"began","number":{number},"repetition":{repetition}'
    return b"{" + text.encode() + b"}"


@pytest.mark.parametrize(
    "event",
    [
        lap(3),
        RepetitionEnded(number=1, repetition=1, outcome="fell"),
        RunOver(number=7, repetition=0, reason="why"),
    ],
)
def test_an_event_comes_out_as_it_went_in(event: AnyEvent) -> None:
    assert decode_event(event.encode()) == event


@pytest.mark.parametrize(
    "payload",
    [b"", b"[]", b'{"event": "other"}', b'{"event": "over"}', b'{"number": 1, "repetition": 1}'],
)
def test_what_is_no_event_is_told(payload: bytes) -> None:
    with pytest.raises(MalformedMessage, match="an event"):
        decode_event(payload)


def test_a_story_is_read_as_it_was_put_together() -> None:
    kept = KeptEvents()
    events: list[AnyEvent] = [lap(1), RepetitionEnded(number=2, repetition=1, outcome="steady")]
    assert RunStory.decode(kept.story()).events == []
    for event in events:
        kept.keep(event.encode())
    assert RunStory.decode(kept.story()).events == events
    assert not kept.is_over
    kept.keep(RunOver(number=3, repetition=1).encode())
    assert kept.is_over
    assert kept.number == 3


def test_laps_of_the_repetition_before_are_not_told_and_a_long_one_tells_the_newest() -> None:
    kept = KeptEvents()
    for number in range(1, MOST_LAPS + 2):
        kept.keep(lap(number).encode())
    told = [event.number for event in RunStory.decode(kept.story()).events]
    assert told == list(range(2, MOST_LAPS + 2))
    kept.keep(began(MOST_LAPS + 2, 2))
    kept.keep(lap(MOST_LAPS + 3, 2).encode())
    assert kept.repetition == 2
    assert kept.story().count(b'"event":"lap"') == 1
    assert kept.story().count(b'"event":"began"') == 1
