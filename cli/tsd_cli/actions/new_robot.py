"""A robot file for a robot of one's own."""

from __future__ import annotations

import shlex
import tempfile
from pathlib import Path
from typing import Any

import typer

from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_casadi.proposal.data_package import find_in_package
from tsd_casadi.proposal.propose import STEPS, Proposal, name_for, propose_robot_file
from tsd_casadi.proposal.source_path import package_of
from tsd_casadi.robot.robot import Robot
from tsd_casadi.whole_file import check_writable, write_whole
from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.proposal import ProposalOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.progress import show_progress

# exit code for a file that is written and that nothing can be done with
OF_NO_USE = 1


@interruptible("no robot file was written")
def write_new_robot(file: Path | None, wanted: ProposalOptions, output: JsonOptions) -> None:
    """Propose a robot file, see that it loads, and write it.

    Raises:
        TsdError: If the description cannot be used, or the file is there already.
    """
    feet = _read_feet(wanted.feet)
    locks = wanted.lock or []
    if wanted.package is not None:
        source, notes = find_in_package(wanted.package, feet, locks, file)
    elif file is not None:
        source, notes = file, []
    else:
        raise InvalidValue("FILE", "missing", "a URDF or MJCF, or --package NAME")
    name = name_for(wanted.name or wanted.package or source.stem)
    robot_file = wanted.out or _place(source, name)
    if robot_file.exists() and not wanted.force:
        raise InvalidValue(
            "the robot file", f"'{robot_file}'", "one that is not there yet, or --force"
        )
    check_outputs(output)
    check_writable(robot_file)
    with show_progress(f"proposing {name}", len(STEPS)) as progress:
        proposal = propose_robot_file(source, feet, locks, name, robot_file, progress)
        _check_loading(proposal, robot_file)
    with write_whole(robot_file) as written:
        written.write(proposal.text.encode())
    result = _result(proposal, robot_file, [*notes, *proposal.notes])
    put_out(result, output, lambda: _print(result))
    if proposal.problems:
        for problem in proposal.problems:
            typer.echo(f"{robot_file} is written, but {problem}", err=True)
        raise typer.Exit(OF_NO_USE)


def _read_feet(text: str) -> tuple[str, str]:
    names = [part.strip() for part in text.split(",")]
    if len(names) != 2 or not all(names):
        raise InvalidValue("--feet", f"'{text}'", "two names with a comma, LEFT,RIGHT")
    return names[0], names[1]


def _place(source: Path, name: str) -> Path:
    """Choose where the robot file goes: here, or where it may name its description."""
    here = Path(f"{name}.yaml")
    if source.resolve().is_relative_to(Path.cwd()) or package_of(source) is not None:
        return here
    return source.parent / here


def _check_loading(proposal: Proposal, robot_file: Path) -> None:
    """Load what will be written, from a name of its own beside it."""
    with tempfile.NamedTemporaryFile(
        dir=robot_file.parent, prefix=f".{robot_file.name}.", suffix=".yaml"
    ) as draft:
        draft.write(proposal.text.encode())
        draft.flush()
        try:
            Robot(Path(draft.name))
        except RobotFileError as error:
            said = str(error).replace(draft.name, str(robot_file))
            said = said.replace(Path(draft.name).name, robot_file.name)
            raise RobotFileError(
                proposal.survey.description.path,
                "",
                f"leads to a robot file that cannot be used ({said})",
                "a description without that",
            ) from error


def _result(proposal: Proposal, robot_file: Path, notes: list[str]) -> dict[str, Any]:
    home = proposal.home
    return {
        "robot": proposal.name,
        "file": str(robot_file),
        "source": str(proposal.survey.description.path),
        "joints": proposal.survey.body.n,
        "locked": list(proposal.survey.locks.angles),
        "home": {
            "height_m": home.posed.height,
            "knee_rad": home.posed.bend,
            "margin_rad": home.posed.margin,
            "torque_share": home.posed.share,
        },
        "motions": {
            motion: {name: list(ends) for name, ends in ranges.items()}
            for motion, ranges in proposal.ranges.items()
        },
        "notes": notes,
        "problems": proposal.problems,
    }


def _print(result: dict[str, Any]) -> None:
    typer.echo(f"{result['file']}: {result['robot']}, {result['joints']} joints that move")
    for note in result["notes"]:
        typer.echo(f"  - {note}")
    motions = [
        f"{motion} up to {ranges['amplitude'][1]:g} {'rad' if motion == 'twist' else 'm'}"
        for motion, ranges in result["motions"].items()
    ]
    typer.echo(f"  - {', '.join(motions) or 'no room for any motion'}")
    typer.echo(f"next: tsd robot check {shlex.quote(result['file'])}")
