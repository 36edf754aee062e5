"""How long a user waits for a controller that stopped answering."""

from __future__ import annotations

import math

from tsd_casadi.exceptions import InvalidValue

# a restarted service is there within seconds, on a loaded machine within a quarter
# of a minute; twice that
PATIENCE = 30.0  # s


def check_patience(patience: float) -> None:
    """Refuse a time that nobody can wait.

    Raises:
        InvalidValue: If it is not above 0 [s].
    """
    if math.isnan(patience) or patience <= 0:
        raise InvalidValue("patience", f"{patience:g} s", "above 0 s; 'inf' waits for ever")
