"""Services that run here, looked after all the time: how they are, and which are gone."""

from __future__ import annotations

import threading
from contextlib import suppress
from dataclasses import dataclass

from tsd_casadi.exceptions import TsdError
from tsd_casadi.wire.health import HealthMessage
from tsd_casadi.wire.run_directory import running
from tsd_casadi.wire.run_record import RunRecord
from tsd_clients.remote.service_health import NO_ANSWER, ROLES, ask_health, why_not_asked
from tsd_clients.remote.session import Session

# a look at the run directory costs some system calls; a service that is gone has to be
# told within a second [s]
LOOK = 0.25
# between two questions how a service is [s]
ASK = 1.0


@dataclass(frozen=True)
class WatchedService:
    """A service that is here, or was.

    Attributes:
        record: What it said of itself in the run directory, the newest of its subject.
        lost: Monotonic time at which it was gone; None while it is here.
        health: What it answered last, if it did.
        trouble: Why it did not.
    """

    record: RunRecord
    lost: float | None = None
    health: HealthMessage | None = None
    trouble: str = ""


class ServiceWatch:
    """Polled by the page; asks in a thread of its own, for an answer may take its time."""

    def __init__(self) -> None:
        """Begin to look."""
        self._here: dict[tuple[str, str], RunRecord] = {}
        self._lost: dict[tuple[str, str], float] = {}
        self._answers: dict[int, tuple[HealthMessage | None, str]] = {}
        self._looked = float("-inf")
        self._stopped = threading.Event()
        self._news = threading.Event()
        self._asking = threading.Thread(target=self._ask, name="health", daemon=True)
        self._asking.start()

    @property
    def services(self) -> tuple[WatchedService, ...]:
        """All services that were here since the page was opened, by role and subject."""
        return tuple(
            WatchedService(
                record,
                self._lost.get(name),
                *self._answers.get(record.instance, (None, "")),
            )
            for name, record in sorted(self._here.items())
        )

    def poll(self, now: float) -> None:
        """Look what is here."""
        if now < self._looked + LOOK:
            return
        self._looked = now
        found = {
            (record.role, record.subject): record for record in running() if record.role in ROLES
        }
        for name in self._here:
            if name in found:
                self._lost.pop(name, None)
            else:
                self._lost.setdefault(name, now)
        if any(found[name] != self._here.get(name) for name in found):
            self._news.set()
        self._here = {**self._here, **found}

    def close(self) -> None:
        """Stop asking."""
        self._stopped.set()
        self._news.set()
        # it waits for one answer at most
        self._asking.join()

    def _ask(self) -> None:
        sessions: dict[int, Session] = {}
        while not self._stopped.is_set():
            records = [record for name, record in self._here.items() if name not in self._lost]
            for gone in set(sessions) - {record.instance for record in records}:
                sessions.pop(gone).close()
            for record in records:
                self._answers[record.instance] = _answer(record, sessions)
            self._news.wait(ASK)
            self._news.clear()
        for session in sessions.values():
            session.close()


def _answer(record: RunRecord, sessions: dict[int, Session]) -> tuple[HealthMessage | None, str]:
    if trouble := why_not_asked(record):
        return None, trouble
    try:
        if record.instance not in sessions:
            sessions[record.instance] = Session(record.role, record.endpoints[:1])
        return ask_health(sessions[record.instance], record.robot, record.role), ""
    except TsdError:
        with suppress(KeyError):
            sessions.pop(record.instance).close()
        return None, NO_ANSWER
