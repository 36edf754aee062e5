"""Extras of the installation, asked for where something needs them."""

from __future__ import annotations

from importlib.util import find_spec

from tsd_casadi.exceptions import NotAvailable


def require_extra(extra: str, what: str, *modules: str) -> None:
    """Refuse what needs modules that are not installed.

    Args:
        extra: Which extra of the installation brings them.
        what: What needs them, for people: 'a film'.
        modules: Top-level names.

    Raises:
        NotAvailable: If one is missing.
    """
    missing = [module for module in modules if find_spec(module) is None]
    if missing:
        raise NotAvailable(
            what,
            f"{', '.join(missing)}, of the extra '{extra}'",
            f"pip install 'tsd_casadi[{extra}]', in a clone pip install '.[{extra}]'",
        )
