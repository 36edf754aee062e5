from __future__ import annotations

import inspect
from dataclasses import dataclass
from typing import Annotated, Any, get_args

import pytest
import typer

from tsd_casadi.learning.rules.by_name import RULES
from tsd_cli.help_text import unwrap
from tsd_cli.option_groups import with_groups
from tsd_cli.options.learning import RuleChoice


@dataclass(frozen=True, kw_only=True)
class Base:
    """Size.

    More about it.
    """

    width: Annotated[float, typer.Option("--width", help="How wide.")]
    height: Annotated[float, typer.Option("--height", help="How high.")] = 2.0


@dataclass(frozen=True, kw_only=True)
class Derived(Base):
    """Size of a thing."""

    name: Annotated[str, typer.Argument(help="Its name.")]
    width: Annotated[float, typer.Option("--width", help="How wide.")] = 1.0


def test_a_command_gets_its_groups_and_typer_their_fields() -> None:
    given: list[Any] = []

    @with_groups
    def command(
        size: Base, flag: Annotated[bool, typer.Option("--flag", help="Whether.")] = False
    ) -> None:
        """Do it."""
        given.extend([size, flag])

    parameters = inspect.signature(command).parameters
    assert list(parameters) == ["width", "height", "flag"]
    assert parameters["width"].default is inspect.Parameter.empty
    assert (parameters["height"].default, parameters["flag"].default) == (2.0, False)
    command(width=3.0, height=4.0, flag=True)
    assert given == [Base(width=3.0, height=4.0), True]


def test_the_groups_docstring_is_the_heading_of_its_options() -> None:
    @with_groups
    def command(size: Derived) -> None:
        """Do it."""

    infos = {
        name: get_args(parameter.annotation)[1]
        for name, parameter in inspect.signature(command).parameters.items()
    }
    assert infos["width"].rich_help_panel == infos["height"].rich_help_panel == "Size of a thing"
    assert infos["name"].rich_help_panel is None
    # the group's own metadata stays as it was
    assert get_args(Base.__annotations__["width"]) == ()


def test_a_default_of_a_derived_group_counts() -> None:
    @with_groups
    def command(size: Derived) -> None:
        """Do it."""

    assert inspect.signature(command).parameters["width"].default == 1.0


def test_two_groups_with_the_same_field_are_refused() -> None:
    def command(one: Base, other: Derived) -> None:
        """Do it."""

    with pytest.raises(ValueError, match="duplicate parameter name"):
        with_groups(command)


def test_paragraphs_become_lines_and_examples_stay() -> None:
    text = unwrap("One\nline.\n\n  tsd first\n  tsd second\n\nThe\nend.")
    assert text.split("\n\n") == ["One line.", "\b  tsd first\n\b  tsd second", "The end."]


def test_the_rules_that_can_be_chosen_are_those_there_are() -> None:
    assert {choice.value for choice in RuleChoice} == set(RULES)
