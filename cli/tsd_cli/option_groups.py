"""Options that belong together: a dataclass each, whatever command has them.

The fields of a dataclass carry what Typer wants to know of an option, once. A
command takes whole dataclasses::

    @with_groups
    def simulate(motion: MotionOptions, robot: RobotOptions) -> None: ...

and Typer, which knows only single parameters, is shown the fields of all of them
that are annotated for it; whatever calls the command may give the others.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import MISSING, fields, is_dataclass
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from typer.models import OptionInfo

from tsd_cli.help_text import unwrap


def with_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Take the groups of a command apart for Typer, and put them together again.

    Args:
        command: Its parameters are dataclasses, or single options with ``Annotated``.

    Raises:
        ValueError: If two groups have a field of the same name.
    """
    hints = get_type_hints(command, include_extras=True)
    groups: dict[str, type[Any]] = {}
    shown: list[inspect.Parameter] = []
    for name, parameter in inspect.signature(command).parameters.items():
        hint = hints[name]
        if is_dataclass(hint):
            assert isinstance(hint, type)
            groups[name] = hint
            shown += _parameters(hint)
        else:
            kind = inspect.Parameter.KEYWORD_ONLY
            shown.append(parameter.replace(kind=kind, annotation=hint))

    def call(**given: Any) -> None:
        made = {
            name: group(
                **{
                    field.name: given.pop(field.name)
                    for field in fields(group)
                    if field.name in given
                }
            )
            for name, group in groups.items()
        }
        command(**made, **given)

    call.__name__ = command.__name__
    call.__doc__ = unwrap(inspect.getdoc(command) or "")
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in shown}
    vars(call)["__signature__"] = inspect.Signature(shown)
    return call


def _names(group: type[Any]) -> list[str]:
    return [field.name for field in fields(group)]


def _parameters(group: type[Any]) -> Iterator[inspect.Parameter]:
    """List a group's fields; the first line of its docstring is their heading in the help."""
    heading = (inspect.getdoc(group) or "").split("\n", maxsplit=1)[0].rstrip(".")
    hints = get_type_hints(group, include_extras=True)
    for field in fields(group):
        if get_origin(hints[field.name]) is not Annotated:
            continue
        kind, info = get_args(hints[field.name])
        if isinstance(info, OptionInfo):
            info = copy(info)
            info.rich_help_panel = heading
        yield inspect.Parameter(
            field.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=inspect.Parameter.empty if field.default is MISSING else field.default,
            annotation=Annotated[kind, info],
        )
