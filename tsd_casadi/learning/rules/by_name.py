"""The learning rules by their words in messages, database and command line."""

from __future__ import annotations

from collections.abc import Mapping

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.rules.adaptive import Adaptive
from tsd_casadi.learning.rules.guarded import Guarded
from tsd_casadi.learning.rules.plain import Plain
from tsd_casadi.learning.rules.rule import Rule
from tsd_casadi.learning.rules.stable import Stable

_KNOWN: tuple[Rule, ...] = (Guarded(), Plain(), Stable(), Adaptive())
RULES: Mapping[str, Rule] = {rule.name: rule for rule in _KNOWN}


def find_rule(name: str) -> Rule:
    """Find a rule by its word.

    Raises:
        InvalidValue: If there is none.
    """
    if name not in RULES:
        raise InvalidValue("rule", repr(name), f"one of {', '.join(RULES)}")
    return RULES[name]
