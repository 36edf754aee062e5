"""A learner behind Zenoh queries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tsd_casadi.generalization.suggestion import Region, Suggestion
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.instruction import USUAL, Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.wire.endpoints import LEARNER
from tsd_casadi.wire.feedforward import FeedforwardMessage
from tsd_casadi.wire.keys import (
    ANY_ROBOT,
    database_key,
    feedforward_key,
    record_key,
    suggestion_key,
)
from tsd_casadi.wire.learner import DatabaseReply, EntryMessage, RecordReply
from tsd_casadi.wire.listing import LARGEST_PAGE, Listing
from tsd_casadi.wire.question import question_texts
from tsd_casadi.wire.record import RecordMessage
from tsd_casadi.wire.suggestion import SuggestionMessage
from tsd_casadi.wire.zenoh_file import ZenohFile
from tsd_clients.remote.session import Session

# some rules fit the loop's response to all repetitions before they answer: 0.3 s alone,
# several seconds on a machine whose cores are taken [s]
RECORDING = 30.0


class RemoteLearner:
    """Records with and asks a learner service."""

    def __init__(
        self, connect: Sequence[str] = (LEARNER,), *, zenoh_file: ZenohFile | None = None
    ) -> None:
        """Connect.

        Args:
            connect: Endpoints of the service.
            zenoh_file: Certificates and what else the network needs.

        Raises:
            ServiceUnreachable: If no service is there.
        """
        self._session = Session("learner", connect, zenoh_file=zenoh_file)
        try:
            self._session.wait_for(ANY_ROBOT)
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        """Name the endpoints."""
        return f"<RemoteLearner at {', '.join(self._session.endpoints)}>"

    def __enter__(self) -> RemoteLearner:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the session."""
        self.close()

    def close(self) -> None:
        """Close the session."""
        self._session.close()

    def query(
        self,
        motion: str,
        /,
        *,
        robot: str,
        kind: str | None = None,
        extrapolate: bool = False,
        axes: Sequence[str] | None = None,
        context: Context | None = None,
        version: str | None = None,
        **parameters: float,
    ) -> Feedforward:
        """Ask for the feedforward for some parameters of a motion; see ``Database.query``.

        Raises:
            TsdError: What ``Database.query`` raises, ``EntryNotFound`` for instance.
        """
        return self.query_message(
            motion,
            robot=robot,
            kind=kind,
            extrapolate=extrapolate,
            axes=axes,
            context=context,
            version=version,
            **parameters,
        ).feedforward()

    def query_message(
        self,
        motion: str,
        /,
        *,
        robot: str,
        kind: str | None = None,
        extrapolate: bool = False,
        axes: Sequence[str] | None = None,
        context: Context | None = None,
        version: str | None = None,
        **parameters: float,
    ) -> FeedforwardMessage:
        """Ask for a feedforward as it comes over the network."""
        selector = question_texts(motion, parameters, version=version, axes=axes, context=context)
        if kind is not None:
            selector["kind"] = kind
        if extrapolate:
            selector["extrapolate"] = "true"
        body = self._session.query_one(feedforward_key(robot), parameters=selector)
        return FeedforwardMessage.decode(body)

    def suggest(
        self,
        motion: str,
        /,
        *,
        robot: str,
        region: Region,
        axes: Sequence[str] | None = None,
        context: Context | None = None,
        version: str | None = None,
        **parameters: float,
    ) -> Suggestion:
        """Where to learn next; see ``Database.suggest``.

        Raises:
            TsdError: What ``Database.suggest`` raises.
        """
        selector = question_texts(motion, parameters, version=version, axes=axes, context=context)
        for name, (low, high) in region.items():
            selector[name] = f"{float(low)!r}:{float(high)!r}"
        body = self._session.query_one(suggestion_key(robot), parameters=selector)
        return SuggestionMessage.decode(body).suggestion()

    def entries(self, robot: str | None = None, motion: str | None = None) -> list[EntryMessage]:
        """Ask for the entries; see ``Database.entries``."""
        return [entry for page in self.pages(robot, motion) for entry in page.entries]

    def record(
        self, recording: Recording, instruction: Instruction = USUAL
    ) -> tuple[EntryMessage, list[str]]:
        """Hand over one repetition; see ``Database.record``.

        Returns:
            The entry as it is now, and remarks for the user.

        Raises:
            ServiceBusy: If the learner is there but did not answer in time; it may
                have recorded all the same.
            TsdError: What ``Database.record`` raises.
        """
        payload = RecordMessage.of(recording, instruction).encode()
        body = self._session.query_one(
            record_key(recording.key.robot), payload=payload, timeout=RECORDING
        )
        reply = RecordReply.decode(body)
        return reply.entry, reply.notes

    def database(
        self, robot: str | None = None, motion: str | None = None, *, limit: int = LARGEST_PAGE
    ) -> DatabaseReply:
        """Ask what was recorded last.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.
            limit: Largest number of entries.
        """
        return self._page(robot, Listing(motion, limit))

    def pages(self, robot: str | None = None, motion: str | None = None) -> Iterator[DatabaseReply]:
        """Ask for all entries, page by page in the order of their numbers; at least one page."""
        after = 0
        while True:
            page = self._page(robot, Listing(motion, LARGEST_PAGE, after))
            yield page
            numbers = [each.entry for each in page.entries] + [each.entry for each in page.damaged]
            if not page.more or not numbers:
                return
            after = max(numbers)

    def forget(self, entry: int) -> DatabaseReply:
        """Remove an entry.

        Args:
            entry: Its number.

        Raises:
            EntryNotFound: If there is none of that number.
        """
        return self._page(None, Listing(limit=1, forget=entry))

    def _page(self, robot: str | None, listing: Listing) -> DatabaseReply:
        body = self._session.query_one(database_key(robot or ANY_ROBOT), parameters=listing.texts())
        return DatabaseReply.decode(body)
