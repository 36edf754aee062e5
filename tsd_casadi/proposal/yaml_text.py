"""Numbers and names as YAML reads them back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

# of angles: 0.1 mrad moves a foot by less than 0.1 mm and tilts it by less than 0.3 mrad
DIGITS = 4


def list_text(values: Sequence[float] | Any, digits: int = 4) -> str:
    """Write numbers as a list."""
    return f"[{', '.join(number_text(float(value), digits) for value in values)}]"


def number_text(value: float, digits: int = DIGITS) -> str:
    """Write a number with a point, rounded."""
    return repr(round(value, digits) + 0.0)  # minus zero is zero


def key_text(name: str) -> str:
    """Quote what YAML would not read as the text that it is."""
    plain = name.replace("_", "").isalnum() and name[:1].isalpha()
    reserved = name.lower() in ("on", "off", "yes", "no", "true", "false", "null", "y", "n")
    return name if plain and not reserved else "'" + name.replace("'", "''") + "'"
