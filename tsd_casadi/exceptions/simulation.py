"""A simulation cannot be carried out."""

from __future__ import annotations

from tsd_casadi.exceptions.base import TsdError


class SimulationError(TsdError):
    """A simulation could not be carried out as asked."""

    code = "simulation"
