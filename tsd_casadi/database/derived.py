"""Tables that are derived from the rows, so that a question finds its entry without reading all.

They hold nothing that the rows do not say. Triggers of the file keep them, so every
program that adds rows does, an older version of this software too. A file without
them, or with those of another version, gets them at opening.
"""

from __future__ import annotations

import sqlite3

# parameters as one text that is the same for the same numbers: 'amplitude=30000;height=0',
# in millionths, to which they are rounded; NULL where they are damaged
_PLACE = """CASE
    WHEN json_valid(entry.parameters) AND json_type(entry.parameters) = 'object' THEN coalesce((
        SELECT group_concat(name || '=' || value, ';') FROM (
            SELECT key AS name, CAST(round(value * 1e6) AS INTEGER) AS value
            FROM json_each(entry.parameters) ORDER BY key
        )
    ), '') END"""
_GROUP = ("robot", "motion", "version", "body", "formulation", "correction")
_GROUP_COLUMNS = ", ".join(_GROUP)

# statements by name, in the order in which they are made
_DERIVED = {
    "event_of_entry": "CREATE INDEX event_of_entry ON event (entry)",
    "event_forgotten": "CREATE INDEX event_forgotten ON event (entry) WHERE kind = 'forgotten'",
    # how each entry that counts is now; 'sequence' and 'declared' are the newest events that
    # recorded it and said something of its motion
    "entry_state": """CREATE TABLE entry_state (
    entry INTEGER PRIMARY KEY,
    robot TEXT, motion TEXT, version TEXT, axes TEXT, place TEXT,
    body TEXT, formulation TEXT, correction TEXT,
    event INTEGER, updated TEXT, sequence INTEGER, declared INTEGER
)""",
    "entry_state_of_rows": f"""CREATE VIEW entry_state_of_rows AS
SELECT entry.id AS entry, entry.robot, entry.motion, entry.version, entry.axes,
    {_PLACE} AS place,
    newest.body, newest.formulation, newest.correction, newest.id AS event, newest.time AS updated,
    coalesce((SELECT max(id) FROM event WHERE event.entry = entry.id AND kind = 'recorded'), 0)
        AS sequence,
    (SELECT max(id) FROM event WHERE event.entry = entry.id AND declaration IS NOT NULL) AS declared
FROM entry JOIN event AS newest
    ON newest.id = (SELECT max(id) FROM event WHERE event.entry = entry.id)
WHERE NOT EXISTS (SELECT 1 FROM event WHERE event.entry = entry.id AND kind = 'forgotten')""",
    "entry_state_place": "CREATE INDEX entry_state_place ON entry_state (robot, motion, place)",
    "entry_state_group": f"CREATE INDEX entry_state_group ON entry_state ({_GROUP_COLUMNS}, "
    "sequence, updated, entry)",
    "entry_state_declared": "CREATE INDEX entry_state_declared ON entry_state (robot, motion, "
    "version, sequence, updated, entry) WHERE declared IS NOT NULL",
    # how many there are of each version and context
    "entry_count": f"""CREATE TABLE entry_count (
    robot TEXT, motion TEXT, version TEXT, body TEXT, formulation TEXT, correction TEXT,
    entries INTEGER, PRIMARY KEY ({_GROUP_COLUMNS})
) WITHOUT ROWID""",
    "entry_state_added": f"""CREATE TRIGGER entry_state_added AFTER INSERT ON entry_state BEGIN
    INSERT INTO entry_count VALUES ({", ".join(f"NEW.{name}" for name in _GROUP)}, 1)
    ON CONFLICT DO UPDATE SET entries = entries + 1;
END""",
    "entry_state_removed": f"""CREATE TRIGGER entry_state_removed AFTER DELETE ON entry_state BEGIN
    UPDATE entry_count SET entries = entries - 1
    WHERE {" AND ".join(f"{name} = OLD.{name}" for name in _GROUP)};
END""",
    "event_added": """CREATE TRIGGER event_added AFTER INSERT ON event BEGIN
    DELETE FROM entry_state WHERE entry = NEW.entry;
    INSERT INTO entry_state SELECT * FROM entry_state_of_rows WHERE entry = NEW.entry;
END""",
}


def is_derived(connection: sqlite3.Connection) -> bool:
    """Say whether the file has all that is derived, as this version makes it."""
    found = dict(connection.execute("SELECT name, sql FROM sqlite_master"))
    return all(found.get(name) == statement for name, statement in _DERIVED.items())


def derive(connection: sqlite3.Connection) -> None:
    """Make everything derived anew; the caller begins and ends the transaction."""
    kinds = dict(connection.execute("SELECT name, type FROM sqlite_master"))
    for name in reversed(_DERIVED):
        if name in kinds:
            connection.execute(f"DROP {kinds[name]} IF EXISTS {name}")
    for statement in _DERIVED.values():
        connection.execute(statement)
    connection.execute("INSERT INTO entry_state SELECT * FROM entry_state_of_rows")


# what is in one of the tables and does not follow from the rows, or the other way round
DIFFERENCES = (
    "SELECT entry FROM (SELECT * FROM entry_state EXCEPT SELECT * FROM entry_state_of_rows) UNION "
    "SELECT entry FROM (SELECT * FROM entry_state_of_rows EXCEPT SELECT * FROM entry_state)",
    f"SELECT {_GROUP_COLUMNS}, entries FROM entry_count WHERE entries <> 0 EXCEPT "
    f"SELECT {_GROUP_COLUMNS}, count(*) FROM entry_state GROUP BY {_GROUP_COLUMNS}",
    f"SELECT {_GROUP_COLUMNS}, count(*) FROM entry_state GROUP BY {_GROUP_COLUMNS} EXCEPT "
    f"SELECT {_GROUP_COLUMNS}, entries FROM entry_count",
)
