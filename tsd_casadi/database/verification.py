"""Whether everything in a database file is as it was written."""

from __future__ import annotations

from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.database.derived import DIFFERENCES
from tsd_casadi.database.entry_rows import COLUMNS, EntryRows
from tsd_casadi.database.iteration_rows import IterationRow
from tsd_casadi.database.row import Row
from tsd_casadi.database.rows import EntryRow, EventRow
from tsd_casadi.exceptions import DatabaseError

_KINDS: dict[str, type[Row]] = {"entry": EntryRow, "event": EventRow, "iteration": IterationRow}
MOST_FINDINGS = 100


def find_damages(file: DatabaseFile, rows: EntryRows) -> list[str]:
    """Check the file, the checksum of every row, old ones too, and every entry.

    Args:
        file: In a transaction.
        rows: Of the file.

    Returns:
        What is wrong, a sentence each; nothing if all is well.
    """
    try:
        told = [str(row[0]) for row in file.execute(f"PRAGMA integrity_check({MOST_FINDINGS})")]
        found = [f"the file: {text}" for text in told if text != "ok"]
        found += [
            f"a row of '{row[0]}' belongs to none of '{row[2]}'"
            for row in file.execute("PRAGMA foreign_key_check")
        ]
        for table, kind in _KINDS.items():
            names = COLUMNS[table]
            for row in file.execute(f"SELECT {', '.join(names)} FROM {table}"):
                columns = dict(zip(names, row, strict=True))
                try:
                    kind.check(columns)
                except ValueError as error:
                    number = columns["id" if table == "entry" else "entry"]
                    reason = " ".join(str(error).split())
                    found.append(f"entry {number}: a row of '{table}': {reason}")
        found += [
            f"entry {each.identifier}: {each.reason}"
            for each in rows.read()[1]
            if not any(text.startswith(f"entry {each.identifier}:") for text in found)
        ]
        if any(file.execute(statement) for statement in DIFFERENCES):
            found.append("the index does not fit the rows: export the entries, import them anew")
    except DatabaseError as error:
        return [str(error)]
    return found[:MOST_FINDINGS]
