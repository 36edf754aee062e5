"""Entries that were decoded once, for all connections of a process."""

from __future__ import annotations

import threading
from collections import OrderedDict

from tsd_casadi.database.damaged_entry import DamagedEntry
from tsd_casadi.learning.entry import Entry

# twice what one regression may use, so that two motions do not push each other out; some
# 10 kB each
KEPT_ENTRIES = 2_000


class KeptEntries:
    """What was read of entries: by number and newest event, since rows are only ever added.

    An entry that changes has another event, so nothing here is ever out of date,
    whoever writes. Threads may share it; the entries are not to be changed.
    """

    def __init__(self) -> None:
        """Keep nothing yet."""
        self._lock = threading.Lock()
        self._entries: OrderedDict[tuple[int, int], Entry] = OrderedDict()
        self._damaged: dict[int, DamagedEntry] = {}

    def find(self, identifier: int, event: int) -> Entry | None:
        """Find an entry as it is since an event."""
        with self._lock:
            found = self._entries.get((identifier, event))
            if found is not None:
                self._entries.move_to_end((identifier, event))
            return found

    def keep(self, event: int, entry: Entry) -> None:
        """Keep an entry as it is since an event; what was not asked for longest goes."""
        with self._lock:
            self._entries[entry.identifier, event] = entry
            if len(self._entries) > KEPT_ENTRIES:
                self._entries.popitem(last=False)

    def note(self, damaged: DamagedEntry) -> None:
        """Note that an entry could not be read."""
        with self._lock:
            self._damaged[damaged.identifier] = damaged

    def forget(self, identifier: int) -> None:
        """Note that an entry counts no more."""
        with self._lock:
            self._damaged.pop(identifier, None)

    @property
    def damaged(self) -> int:
        """Number of entries that could not be read."""
        with self._lock:
            return len(self._damaged)
