"""A learner that is asked in a thread, so that a page never waits for it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager

from tsd_casadi.exceptions import TsdError
from tsd_casadi.exceptions.services import ServiceError
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.wire.learner import EntryMessage
from tsd_clients.viewer.explorer import Asked, Explorer, ListingLearner
from tsd_clients.viewer.known_motion import KnownMotion, known_motions
from tsd_clients.viewer.prediction import LearnedCurve, Prediction

# how often it is asked whether something was recorded [s]
REFRESH = 1.0
NOBODY = "no learner answers yet"


class LearnerLink:
    """Keeps a link to a learner, lists what it knows and asks what a page wants to know.

    A question that waits gives way to a newer one: while somebody drags a slider its
    values come faster than a learner answers, and what is shown is the newest that there
    was time for. Attributes are read by any thread.

    Attributes:
        entries: Everything in its database.
        motions: What can be explored of it, what was learned last first.
        listed: Counts how often they changed.
        trouble: Why the learner does not answer; empty while it does.
        prediction: The newest answer, and the question.
        curve: What is served of the entry that was looked at last, if that is known.
        declarations: What is said of the motions that were asked about.
    """

    def __init__(self, open_learner: Callable[[], AbstractContextManager[ListingLearner]]) -> None:
        """Start the thread.

        Args:
            open_learner: Connects, or raises a ``TsdError``; called again after a
                service was gone.
        """
        self.entries: tuple[EntryMessage, ...] = ()
        self.motions: tuple[KnownMotion, ...] = ()
        self.listed = 0
        self.trouble = NOBODY
        self.prediction: tuple[Asked, Prediction] | None = None
        self.declarations: dict[tuple[str, str, str], Declaration | None] = {}
        self._open_learner = open_learner
        self.curve: LearnedCurve | None = None
        self._asked: Asked | None = None
        self._looked_at: EntryMessage | None = None
        self._closing = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="learner link", daemon=True)
        self._thread.start()

    def ask(self, asked: Asked) -> None:
        """Put a question in place of the one that waits."""
        with self._changed:
            self._asked = asked
            self._changed.notify()

    def look_at(self, entry: EntryMessage) -> None:
        """Ask for what is served of an entry, in place of the one that waits."""
        with self._changed:
            self._looked_at = entry
            self._changed.notify()

    def poll(self, now: float) -> None:
        """Do nothing: the thread asks by itself."""

    def close(self) -> None:
        """End the thread, once what it is about is answered; what waits is dropped."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join()

    def declaration(self, known: KnownMotion) -> Declaration | None:
        """Tell what is said of a motion, as far as it was asked for."""
        return self.declarations.get((known.robot, known.motion, known.version))

    def _run(self) -> None:
        while not self._closing:
            try:
                with self._open_learner() as learner:
                    self._serve(Explorer(learner))
            except TsdError as error:
                self.trouble = str(error)
            with self._changed:
                self._changed.wait_for(lambda: self._closing, REFRESH)

    def _serve(self, explorer: Explorer) -> None:
        while not self._closing:
            if explorer.refresh():
                self._describe(explorer)
            self.trouble = ""
            with self._changed:
                self._changed.wait_for(self._has_work, REFRESH)
                asked, entry = self._asked, self._looked_at
            if asked is not None:
                self.prediction = asked, explorer.predict(asked)
            if entry is not None:
                known = known_motions([entry])
                self.curve = explorer.curve(known[0], entry) if known else None
            with self._changed:
                # what could not be answered is asked again once somebody answers
                self._asked = None if self._asked is asked else self._asked
                self._looked_at = None if self._looked_at is entry else self._looked_at

    def _has_work(self) -> bool:
        return self._closing or self._asked is not None or self._looked_at is not None

    def _describe(self, explorer: Explorer) -> None:
        for known in explorer.motions:
            key = known.robot, known.motion, known.version
            if key not in self.declarations:
                self.declarations[key] = self._declaration(explorer, known)
        self.entries, self.motions = tuple(explorer.entries), tuple(explorer.motions)
        self.listed += 1

    def _declaration(self, explorer: Explorer, known: KnownMotion) -> Declaration | None:
        try:
            return explorer.declaration(known)
        except ServiceError:
            raise
        except TsdError:
            return None  # of another version of this software, for instance
