"""What the learner is told to do with a recording."""

from __future__ import annotations

from dataclasses import dataclass, field

from tsd_casadi.learning.rules.guarded import Guarded
from tsd_casadi.learning.rules.rule import Rule


@dataclass(frozen=True)
class Instruction:
    """An order to the learner, no part of what was recorded.

    Attributes:
        rule: How the entry goes on.
        update: False to note the errors only, without learning from the laps.
        restart: Forget the entry first.
    """

    rule: Rule = field(default_factory=Guarded)
    update: bool = True
    restart: bool = False


USUAL = Instruction()
