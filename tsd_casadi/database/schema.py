"""The tables of a database file, and how they came from those of older versions."""

from __future__ import annotations

import json
import sqlite3

from tsd_casadi.motions.parameter import default_parameters

APPLICATION_ID = 0x54534443  # 'TSDC', in the file's header
SCHEMA_VERSION = 3

SCHEMA = """
CREATE TABLE entry (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    robot TEXT NOT NULL,
    task TEXT NOT NULL,
    axes TEXT NOT NULL,           -- JSON list of 'task.axis'
    parameters TEXT NOT NULL,     -- JSON object, SI units, rounded to 1e-6
    basis_size INTEGER NOT NULL,  -- L
    basis_width REAL NOT NULL,    -- h
    context TEXT NOT NULL,        -- JSON: formulation, model, gains, version
    learning_gain REAL NOT NULL,
    rule TEXT NOT NULL,
    updated TEXT NOT NULL,        -- ISO 8601, UTC
    UNIQUE (robot, task, axes, parameters)
);
CREATE TABLE iteration (
    entry INTEGER NOT NULL REFERENCES entry (id) ON DELETE CASCADE,
    number INTEGER NOT NULL,
    learned_from INTEGER,         -- number of another, NULL if from elsewhere or unknown
    weights TEXT NOT NULL,        -- JSON, k rows of L numbers [m/s^2]
    errors TEXT,                  -- JSON object, NULL while untested
    gains TEXT,                   -- JSON object, the gains of that test
    feedback TEXT,                -- JSON, the fitted feedback of that test, as weights
    error_weights TEXT,           -- JSON, its fitted position error, as weights [m]
    reference_weights TEXT,       -- JSON, its fitted reference, as weights [m]
    PRIMARY KEY (entry, number)
);
"""

# columns of iteration that version 1 did not have
ADDED = {
    "learned_from": "INTEGER",
    "feedback": "TEXT",
    "error_weights": "TEXT",
    "reference_weights": "TEXT",
}


def prepare(connection: sqlite3.Connection) -> None:
    """Make the tables of a new file, bring an older file up to date.

    Args:
        connection: Opened with isolation_level=None.

    Raises:
        sqlite3.OperationalError: If the file cannot be read or written.
        sqlite3.DatabaseError: If it is somebody else's or of an unknown version;
            it is left as it was.
    """
    if _version(connection) != SCHEMA_VERSION:
        # another process may be at the same: look again once it is done
        connection.execute("BEGIN IMMEDIATE")
        version = _version(connection)
        if version == 0:
            _make(connection)
        elif version < SCHEMA_VERSION:
            _migrate(connection)
        connection.execute("COMMIT")
    # a file that cannot be written to is told now, not at the first recording
    connection.execute("BEGIN IMMEDIATE")
    connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
    connection.execute("COMMIT")
    connection.execute("PRAGMA foreign_keys = ON")


def _make(connection: sqlite3.Connection) -> None:
    for statement in SCHEMA.split(";\n")[:-1]:
        connection.execute(statement)
    connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def _migrate(connection: sqlite3.Connection) -> None:
    """Bring up a file of version 1, which kept no feedback and knew squats at home only, or 2.

    Version 2 did not know what an iteration was learned from.
    """
    known = {row[1] for row in connection.execute("PRAGMA table_info(iteration)")}
    for column, kind in ADDED.items():
        if column not in known:
            connection.execute(f"ALTER TABLE iteration ADD COLUMN {column} {kind}")
    for identifier, motion, text in connection.execute(
        "SELECT id, task, parameters FROM entry"
    ).fetchall():
        complete = {**default_parameters(motion), **json.loads(text)}
        connection.execute(
            "UPDATE entry SET parameters = ? WHERE id = ?",
            (json.dumps(dict(sorted(complete.items()))), identifier),
        )
    connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def _version(connection: sqlite3.Connection) -> int:
    """Read the version of the file's tables, 0 for a new file.

    Raises:
        sqlite3.DatabaseError: If it is somebody else's.
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
