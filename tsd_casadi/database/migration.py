"""How a file of an older version becomes one of this version, with a backup beside it."""

from __future__ import annotations

import json
import math
import sqlite3
from pathlib import Path
from typing import Any

from tsd_casadi.database.checksum import with_checksum
from tsd_casadi.database.columns import encode
from tsd_casadi.database.schema import make_tables
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.motions.parameter import Parameter
from tsd_casadi.whole_file import write_whole

# the only motion that older versions knew, as it was when they did
SQUAT = Declaration(
    "squat",
    "1",
    (
        Parameter("amplitude", "m", "half of peak to peak", low=0.0),
        Parameter("frequency", "Hz", "laps per second", default=0.25, low=0.01),
        Parameter("height", "m", "middle of the motion above home", default=0.0),
    ),
)
# of a motion of which nobody said a version
FIRST = "1"
# of older errors: what they are called now, and what they were called
_MEASURES = {
    "rms": "rms_error_m",
    "peak": "peak_error_m",
    "ac_rms": "ac_rms_error_m",
    "mean_abs_feedback": "mean_abs_feedback",
    "true_rms": "true_rms_error_m",
}
_MOST_BACKUPS = 100


def migrate(connection: sqlite3.Connection, path: Path, version: int) -> None:
    """Bring up a file of version 1 to 3; the caller begins and ends the transaction.

    Nobody wrote down fingerprints as they are made today: those of migrated
    entries are unknown. Version 1 kept no feedback and knew squats at home
    only, version 2 not what an iteration was learned from.

    Args:
        connection: To the file, with the tables of that version.
        path: The file; the backup is made beside it.
        version: Of the file.

    Raises:
        InvalidValue: If no backup can be written.
        sqlite3.Error: If the file cannot be read or written.
        ValueError: If what it holds makes no sense.
    """
    backup, is_new = _back_up(path, version)
    try:
        _rewrite(connection)
    except BaseException:
        if is_new:
            backup.unlink(missing_ok=True)  # the file stays as it is
        raise


def _rewrite(connection: sqlite3.Connection) -> None:
    entries, iterations = (_rows(connection, table) for table in ("entry", "iteration"))
    for table in ("iteration", "entry"):
        connection.execute(f"DROP TABLE {table}")
    make_tables(connection)
    for event, old in enumerate(entries, start=1):
        axes = json.loads(old["axes"])
        old_context = json.loads(old["context"])
        parameters = json.loads(old["parameters"])
        if old["task"] == SQUAT.motion:
            parameters = {"height": 0.0, **parameters}
        _insert(
            connection,
            "entry",
            id=old["id"],
            robot=old["robot"],
            motion=old["task"],
            version=FIRST,
            axes=encode(axes),
            parameters=encode(dict(sorted(parameters.items()))),
            basis_kind="periodic",
            basis=encode({"L": old["basis_size"], "width": old["basis_width"]}),
        )
        gains = _gains(old_context["gains"])
        version = old_context["version"]
        _insert(
            connection,
            "event",
            id=event,
            entry=old["id"],
            kind="migrated",
            time=old["updated"],
            body="",
            formulation="",
            correction="",
            declaration=encode(SQUAT) if old["task"] == SQUAT.motion else None,
            circumstances=encode({"gains": gains, "setting": {}, "version": version}),
            rule=old["rule"],
            learning_gain=old["learning_gain"],
        )
        for each in iterations:
            if each["entry"] == old["id"]:
                _insert_iteration(connection, event, each, axes, version)


def _insert_iteration(
    connection: sqlite3.Connection, event: int, old: dict[str, Any], axes: list[str], version: str
) -> None:
    errors, circumstances = None, None
    if old["errors"] is not None:
        # one measure for all axes, as it was
        error = _error(json.loads(old["errors"]))
        errors = encode({axis: error.plain() for axis in axes})
        gains = _gains(json.loads(old["gains"]) if old["gains"] else {})
        circumstances = encode({"gains": gains, "setting": {}, "version": version})
    _insert(
        connection,
        "iteration",
        entry=old["entry"],
        number=old["number"],
        event=event,
        learned_from=old.get("learned_from"),
        epoch=0,
        weights=old["weights"],
        uncertainty=None,
        errors=errors,
        circumstances=circumstances,
        feedback=old.get("feedback"),
        error_weights=old.get("error_weights"),
        reference_weights=old.get("reference_weights"),
    )


def _error(old: dict[str, float]) -> AxisError:
    known: dict[str, Any] = {
        name: float(old[before])
        for name, before in _MEASURES.items()
        if old.get(before) is not None and math.isfinite(old[before])
    }
    if "rms" not in known:
        raise ValueError("errors without a valid rms_error_m")
    return AxisError(**known)


def _gains(old: dict[str, Any]) -> dict[str, Any]:
    """Keep what tells tests apart today: the weight in the cost was among them once."""
    return {name: values for name, values in old.items() if name in ("P", "D")}


def _rows(connection: sqlite3.Connection, table: str) -> list[dict[str, Any]]:
    cursor = connection.execute(f"SELECT * FROM {table}")
    names = [column[0] for column in cursor.description]
    return [dict(zip(names, row, strict=True)) for row in cursor.fetchall()]


def _insert(connection: sqlite3.Connection, table: str, **columns: Any) -> None:
    row = with_checksum(columns)
    marks = ", ".join("?" for _ in row)
    connection.execute(
        f"INSERT INTO {table} ({', '.join(row)}) VALUES ({marks})", tuple(row.values())
    )


def _back_up(path: Path, version: int) -> tuple[Path, bool]:
    """Copy the file; a copy that is there already and the same is enough."""
    before = path.read_bytes()
    for number in range(1, _MOST_BACKUPS):
        suffix = "" if number == 1 else f"-{number}"
        backup = path.with_name(f"{path.name}.v{version}-backup{suffix}")
        if not backup.exists():
            break
        if backup.read_bytes() == before:
            return backup, False
    else:
        raise InvalidValue("backups", f"{_MOST_BACKUPS} beside {path}", "room for another")
    with write_whole(backup) as copy:
        copy.write(before)
    return backup, True
