"""A learner that tells who watches what came of each recording."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from tsd_casadi.exceptions import TsdError
from tsd_casadi.learning.axis_error import AxisError, rank
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.repetition.learn import Learned, Learner
from tsd_casadi.state import Matrix
from tsd_casadi.wire.basis import BasisMessage
from tsd_casadi.wire.learner import EntryMessage, IterationMessage
from tsd_casadi.wire.telemetry import IterationRecorded
from tsd_clients.telemetry.telemetry import Telemetry


class TellingLearner:
    """Records with and asks another learner, and publishes each iteration."""

    def __init__(self, learner: Learner, telemetry: Telemetry) -> None:
        """Stand before a learner.

        Args:
            learner: Database or learner service.
            telemetry: Publishes the run.
        """
        self._learner, self._telemetry = learner, telemetry

    def query(self, motion: str, /, **question: Any) -> Feedforward:
        """Ask the learner."""
        return self._learner.query(motion, **question)

    def record(self, recording: Recording, instruction: Instruction) -> tuple[Learned, list[str]]:
        """Record with the learner, and publish what came of it."""
        entry, notes = self._learner.record(recording, instruction)
        described = EntryMessage.of(entry) if isinstance(entry, Entry) else entry
        if isinstance(described, EntryMessage):
            self._publish(recording, described, notes)
        return entry, notes

    def _publish(self, recording: Recording, entry: EntryMessage, notes: Sequence[str]) -> None:
        tested = _tested(entry, recording.errors)
        if tested is None or tested.errors is None:
            return
        after = self._served(recording)
        P = recording.circumstances.gains.get("P")
        score = math.nan if P is None else rank(recording.errors, P)
        self._telemetry.say(
            IterationRecorded,
            entry=entry.entry,
            motion=entry.motion,
            parameters=dict(recording.key.parameters),
            axes=recording.key.axes,
            iteration=tested.number,
            learned_from=tested.learned_from,
            epoch=tested.epoch,
            errors=tested.errors,
            rank=score if math.isfinite(score) else None,
            basis=BasisMessage.of(recording.basis),
            before=recording.applied.tolist(),
            after=None if after is None else after.tolist(),
            served=entry.served,
            learning_gain=entry.learning_gain,
            rule=entry.rule,
            contractions=entry.contractions,
            notes=list(notes),
        )

    def _served(self, recording: Recording) -> Matrix | None:
        """Ask for the weights that are served now; None if nobody tells."""
        key = recording.key
        with suppress(TsdError):
            served = self._learner.query(
                key.motion,
                robot=key.robot,
                kind="learned",
                extrapolate=False,
                axes=key.axes,
                context=key.context,
                version=key.version,
                **dict(key.parameters),
            )
            return served.over(key.axes).weights
        return None


def _tested(entry: EntryMessage, errors: dict[str, AxisError]) -> IterationMessage | None:
    """Find the iteration that a recording tested: the newest with its errors."""
    for iteration in reversed(entry.iterations):
        known = iteration.errors
        if known is not None and all(
            axis in known and known[axis].rms == error.rms for axis, error in errors.items()
        ):
            return iteration
    return None
