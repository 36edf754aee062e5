"""A motion's own parameters as options: of whatever motion the command line names.

The options of ``tsd simulate squat`` are not those of ``tsd simulate twist``. So
the motion is looked for first, and the command that Typer is shown has options
for what the motion declares.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tsd_cli.options.motion import MotionOptions

if TYPE_CHECKING:
    from tsd_casadi.motions.declaration import Declaration
    from tsd_casadi.motions.parameter import Parameter

METAVARS = {"m": "METRES", "Hz": "HERTZ", "rad": "RADIANS", "s": "SECONDS", "1": "FACTOR"}


def named_motion(arguments: Sequence[str], command: Any) -> str | None:
    """Find the motion among a command's arguments.

    Args:
        arguments: Behind the name of the command.
        command: Click's command, without options of any motion.

    Returns:
        The first word that is no option, no option's value and no number; None if
        there is none, which the command itself will say.
    """
    valued = {
        name
        for option in command.params
        if option.param_type_name == "option" and not option.is_flag
        for name in option.opts
    }
    words = iter(arguments)
    for word in words:
        if word in valued:
            next(words, None)
        elif not word.startswith("-") and not _is_number(word):
            return word
    return None


def with_parameters(
    command: Callable[..., None], declaration: Declaration, *, moves: bool
) -> Callable[..., None]:
    """Give a command options for the parameters of a motion.

    Args:
        command: From ``with_groups``, with ``MotionOptions`` among its groups.
        declaration: Of the motion.
        moves: Whether it moves the robot: it may choose what is usual then.

    Raises:
        InvalidValue: If the command has an option of that name.
    """
    from tsd_casadi.exceptions import InvalidValue

    signature = inspect.signature(command)
    shown = list(signature.parameters.values())
    own = [_option(item, moves) for item in declaration.parameters]
    for option in own:
        if option.name in signature.parameters:
            raise InvalidValue(
                f"parameter of {declaration.motion}",
                f"'{option.name}'",
                "another name: the command line has an option of this one",
            )
    place = 1 + next(index for index, each in enumerate(shown) if each.name == "motion")
    shown[place:place] = own

    def call(**given: Any) -> None:
        parameters = {option.name: given.pop(option.name) for option in own}
        said = {name: value for name, value in parameters.items() if value is not None}
        command(**given, parameters=said)

    call.__name__, call.__doc__ = command.__name__, command.__doc__
    call.__annotations__ = {each.name: each.annotation for each in shown}
    vars(call)["__signature__"] = inspect.Signature(shown)
    return call


def _option(item: Parameter, moves: bool) -> inspect.Parameter:
    default = item.default
    if default is None and moves:
        default = item.usual
    info = typer.Option(
        f"--{item.name.replace('_', '-')}",
        metavar=METAVARS.get(item.unit, item.unit.upper() or "VALUE"),
        help=f"{item.meaning[:1].upper()}{item.meaning[1:]}." if item.meaning else None,
        show_default=False if default is None else f"usually {default:g}",
        rich_help_panel=(inspect.getdoc(MotionOptions) or "").rstrip("."),
    )
    return inspect.Parameter(
        item.name,
        inspect.Parameter.KEYWORD_ONLY,
        # what nobody typed is chosen for the robot, which is not known yet
        default=inspect.Parameter.empty if default is None else None,
        annotation=Annotated[float if default is None else float | None, info],
    )


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
