"""What the command line says of learning rules is what the rules say."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_type_hints

from tsd_casadi.learning.rules.by_name import RULES
from tsd_cli.options.learning import LearningOptions, RuleChoice

LEARNING = Path(__file__).parents[2] / "docs" / "learning.md"


def test_every_rule_can_be_chosen() -> None:
    assert {choice.value for choice in RuleChoice} == RULES.keys()


def test_help_tells_when_each_rule_stops() -> None:
    (option,) = get_type_hints(LearningOptions, include_extras=True)["stop_after"].__metadata__
    told = {name: int(count) for count, name in re.findall(r"(\d+) with --rule (\w+)", option.help)}
    assert told == {rule.name: rule.patience for rule in RULES.values() if rule.patience}


def test_the_documentation_names_the_option_that_ends_learning() -> None:
    told = re.search(
        r"ends after `--([a-z-]+) N` iterations\s+in a row \((\d+)\)", LEARNING.read_text()
    )
    assert told is not None
    option, count = told.groups()
    assert option.replace("-", "_") == "stop_after"
    assert {int(count)} == {rule.patience for rule in RULES.values() if rule.patience}
