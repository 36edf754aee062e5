"""The tables of a database file.

Rows are only ever added, never changed or removed: an entry is what its events
and the newest row of each of its iterations say.
"""

from __future__ import annotations

import sqlite3

APPLICATION_ID = 0x54534443  # 'TSDC', in the file's header
SCHEMA_VERSION = 4

SCHEMA = """
CREATE TABLE entry (
    id INTEGER PRIMARY KEY,
    robot TEXT NOT NULL,
    motion TEXT NOT NULL,
    version TEXT NOT NULL,        -- of the motion
    axes TEXT NOT NULL,           -- JSON list of 'task.axis'
    parameters TEXT NOT NULL,     -- JSON object, SI units, rounded to 1e-6
    basis_kind TEXT NOT NULL,     -- 'periodic'
    basis TEXT NOT NULL,          -- JSON, its numbers: L and width
    checksum TEXT NOT NULL        -- of all other columns, as in every table
);
CREATE TABLE event (
    id INTEGER PRIMARY KEY,
    entry INTEGER NOT NULL REFERENCES entry (id),
    kind TEXT NOT NULL,           -- 'recorded', 'imported', 'migrated' or 'forgotten'
    time TEXT NOT NULL,           -- ISO 8601, UTC
    body TEXT NOT NULL,           -- the context: fingerprints, empty if unknown
    formulation TEXT NOT NULL,
    correction TEXT NOT NULL,
    declaration TEXT,             -- JSON, what is said of the motion
    circumstances TEXT NOT NULL,  -- JSON: gains, setting, version of the software
    rule TEXT NOT NULL,
    learning_gain REAL NOT NULL,
    checksum TEXT NOT NULL
);
CREATE TABLE iteration (
    entry INTEGER NOT NULL REFERENCES entry (id),
    number INTEGER NOT NULL,
    event INTEGER NOT NULL REFERENCES event (id),  -- the newest counts
    learned_from INTEGER,         -- number of another, NULL if from elsewhere or unknown
    epoch INTEGER NOT NULL,       -- counts how often the robot has changed before
    weights TEXT NOT NULL,        -- JSON, k rows of L numbers [m/s^2, rad/s^2]
    uncertainty TEXT,             -- JSON, standard deviation of the weights
    errors TEXT,                  -- JSON object by axis, NULL while untested
    circumstances TEXT,           -- JSON, of that test
    feedback TEXT,                -- JSON, the fitted feedback of that test, as weights
    error_weights TEXT,           -- JSON, its fitted position error, as weights [m, rad]
    reference_weights TEXT,       -- JSON, its fitted reference, as weights [m, rad]
    checksum TEXT NOT NULL,
    PRIMARY KEY (entry, number, event)
);
"""
TABLES = ("entry", "event", "iteration")
_ONLY_ADDED = """
CREATE TRIGGER {table}_{verb} BEFORE {verb} ON {table}
BEGIN SELECT RAISE(ABORT, 'rows are only ever added'); END
"""


def make_tables(connection: sqlite3.Connection) -> None:
    """Make the tables; the caller begins and ends the transaction."""
    for statement in SCHEMA.split(";\n")[:-1]:
        connection.execute(statement)
    for table in TABLES:
        for verb in ("UPDATE", "DELETE"):
            connection.execute(_ONLY_ADDED.format(table=table, verb=verb))
    connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def read_version(connection: sqlite3.Connection) -> int:
    """Read the version of the file's tables, 0 for a new file.

    Raises:
        sqlite3.DatabaseError: If it is somebody else's or of an unknown version.
    """
    (tables,) = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
    (application,) = connection.execute("PRAGMA application_id").fetchone()
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    if tables == 0 and application == 0:
        return 0
    if application != APPLICATION_ID:
        raise sqlite3.DatabaseError("another application's file")
    if not 1 <= version <= SCHEMA_VERSION:
        raise sqlite3.DatabaseError(
            f"schema version {version}, this software knows 1 to {SCHEMA_VERSION}"
        )
    return int(version)


def check_tables(connection: sqlite3.Connection) -> None:
    """Check that the tables are there with their columns.

    Raises:
        sqlite3.DatabaseError: If one is not.
    """
    fresh = sqlite3.connect(":memory:")
    try:
        make_tables(fresh)
        for table in TABLES:
            expected, found = (
                [row[1] for row in each.execute(f"PRAGMA table_info({table})")]
                for each in (fresh, connection)
            )
            if found != expected:
                raise sqlite3.DatabaseError(
                    f"table '{table}' has the columns {', '.join(found) or 'of none'}"
                )
    finally:
        fresh.close()
