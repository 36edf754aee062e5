"""Asking a learner what it knows, and what it would feed forward where."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from tsd_casadi.exceptions import DatabaseError, EntryNotFound, OutsideTrainedRange, TsdError
from tsd_casadi.exceptions.services import ServiceError
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.feedforward_source import FeedforwardSource
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.wire.learner import DatabaseReply, EntryMessage
from tsd_clients.viewer.known_motion import KnownMotion, known_motions, parameters_of
from tsd_clients.viewer.prediction import LearnedCurve, Prediction

# entries whose curves are shown; more would hide the answer
AROUND = 4
# curves that are kept, some kilobytes each
KEPT = 1_000


class ListingLearner(FeedforwardSource, Protocol):
    """A learner that says what it knows, too."""

    def entries(self) -> list[EntryMessage]:
        """List all entries."""

    def database(self, *, limit: int) -> DatabaseReply:
        """List the entries that were recorded last."""


@dataclass(frozen=True)
class Asked:
    """What is asked of a motion.

    Attributes:
        known: The motion, and what there is of it.
        parameters: Of the motion, SI units.
        kind: 'generalised', or None for what was learned where an entry is exactly there.
        extrapolate: Whether to answer outside the learned range too.
    """

    known: KnownMotion
    parameters: Mapping[str, float]
    kind: str | None = None
    extrapolate: bool = False


class Explorer:
    """Explores what a learner knows; for one thread.

    Attributes:
        entries: All that it knew when it was listed last, damaged ones left out.
        motions: Those that learned something, what was learned last first.
    """

    def __init__(self, learner: ListingLearner) -> None:
        """Explore a learner."""
        self._learner = learner
        self._newest: object = None
        self._curves: dict[tuple[int, str, int], LearnedCurve] = {}
        self.entries: list[EntryMessage] = []
        self.motions: list[KnownMotion] = []

    def refresh(self) -> bool:
        """List what is known, if something changed since the last time.

        Returns:
            Whether it did.

        Raises:
            TsdError: If the learner does not answer.
        """
        page = self._learner.database(limit=1)
        # a restarted service may serve another file
        state = page.instance, page.more, [(each.entry, each.updated) for each in page.entries]
        newest = [len(each.iterations) for each in page.entries]
        if (state, newest) == self._newest:
            return False
        self.entries = self._learner.entries()
        self.motions = known_motions(self.entries)
        self._newest = state, newest
        return True

    def declaration(self, known: KnownMotion) -> Declaration | None:
        """Ask what is said of a motion: units, ranges, meanings; None if nobody did.

        Raises:
            TsdError: If the learner does not answer.
        """
        for entry in reversed(known.entries):
            curve = self.curve(known, entry)
            if curve is not None:
                return curve.feedforward.declaration
        return None

    def predict(self, asked: Asked) -> Prediction:
        """Ask for a feedforward, and for the entries around it.

        Raises:
            ServiceError: If the learner does not answer; a refusal is an answer.
        """
        known, parameters = asked.known, dict(asked.parameters)
        exact = known.at(parameters)
        feedforward, refusal, is_beyond = None, "", False
        try:
            feedforward = self._query(known, parameters, asked.kind, asked.extrapolate)
        except ServiceError:
            raise
        except TsdError as error:
            is_beyond = isinstance(error, OutsideTrainedRange)
            refusal = str(error)  # a service that refuses answers
        around = [self.curve(known, each) for each in known.nearest(parameters, AROUND)]
        return Prediction(
            parameters=parameters,
            axes=known.axes,
            feedforward=feedforward,
            refusal=refusal,
            is_beyond=is_beyond,
            around=tuple(curve for curve in around if curve is not None),
            exact=None if exact is None else exact.entry,
        )

    def curve(self, known: KnownMotion, entry: EntryMessage) -> LearnedCurve | None:
        """Ask for what was learned at an entry; None if it cannot be read any more.

        Raises:
            TsdError: If the learner does not answer.
        """
        key = entry.entry, entry.updated, entry.served
        if key not in self._curves:
            try:
                feedforward = self._query(known, parameters_of(entry), "learned", False)
            except (EntryNotFound, DatabaseError):
                return None  # forgotten since it was listed, or damaged
            if len(self._curves) >= KEPT:
                self._curves.pop(next(iter(self._curves)))  # the oldest
            self._curves[key] = LearnedCurve(entry, feedforward)
        return self._curves[key]

    def _query(
        self, known: KnownMotion, parameters: Mapping[str, float], kind: str | None, beyond: bool
    ) -> Feedforward:
        return self._learner.query(
            known.motion,
            robot=known.robot,
            kind=kind,
            extrapolate=beyond,
            axes=known.axes,
            context=known.context,
            version=known.version,
            **parameters,
        )
