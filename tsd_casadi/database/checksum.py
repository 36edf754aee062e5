"""A checksum for each row, so that a damaged one is told before anybody trusts it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

# one for all rows: making it takes longer than a short row
_encode = json.JSONEncoder(default=repr).encode


def checksum(row: Mapping[str, Any]) -> str:
    """Compute the checksum of a row.

    Args:
        row: All columns but the checksum, by name.

    Returns:
        16 hexadecimal digits.
    """
    return hashlib.sha256(_encode(sorted(row.items())).encode()).hexdigest()[:16]


def with_checksum(row: Mapping[str, Any]) -> dict[str, Any]:
    """Give a row with its checksum as the last column."""
    return {**row, "checksum": checksum(row)}
