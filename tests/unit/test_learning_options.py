"""What the command line says of learning rules is what the rules say."""

from __future__ import annotations

import re
from typing import get_type_hints

from tsd_casadi.learning.rules.by_name import RULES
from tsd_cli.options.learning import LearningOptions, RuleChoice


def test_every_rule_can_be_chosen() -> None:
    assert {choice.value for choice in RuleChoice} == RULES.keys()


def test_help_tells_when_each_rule_stops() -> None:
    (option,) = get_type_hints(LearningOptions, include_extras=True)["stop_after"].__metadata__
    told = {name: int(count) for count, name in re.findall(r"(\d+) with --rule (\w+)", option.help)}
    assert told == {rule.name: rule.patience for rule in RULES.values() if rule.patience}
