"""What ruff cannot see: docstrings that are there and say nothing."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = (
    "binding/pinocchio_casadi",
    "tsd_casadi",
    "models/tsd_models",
    "server/tsd_server",
    "clients/tsd_clients",
    "experiments/tsd_experiments",
    "cli/tsd_cli",
    "benchmarks",
)
FILES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
# without a meaning of their own
EMPTY = {"the", "a", "an", "of", "to", "its", "for", "in", "all", "some", "name", "names", "which"}


def words(text: str) -> set[str]:
    """Words and parts of names in lower case, as if all were singular."""
    parts = re.findall(r"[A-Z]?[a-z]+|[A-Z]+|\d+", text)
    return {part.lower().removesuffix("s") for part in parts}


def adds_nothing(argument: str, annotation: str, description: str) -> bool:
    """Whether a description has only words of the argument's name and type."""
    told = {word for word in words(description) if word not in {x.removesuffix("s") for x in EMPTY}}
    return told <= words(argument) | words(annotation)


def described(docstring: str) -> dict[str, str]:
    """Description by argument, from the section 'Args'."""
    section = re.search(r"^Args:\n((?:    .*\n|\n)*)", docstring + "\n", re.MULTILINE)
    found: dict[str, str] = {}
    for line in section.group(1).splitlines() if section else ():
        if entry := re.match(r"    (\w+): (.*)", line):
            last, found[entry[1]] = entry[1], entry[2]
        elif line.strip():
            found[last] += " " + line.strip()
    return found


def functions(tree: ast.Module) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def empty_entries(source: str) -> list[str]:
    """Entries that repeat the name of their argument."""
    found = []
    for function in functions(ast.parse(source)):
        arguments = function.args
        types = {
            argument.arg: "" if argument.annotation is None else ast.unparse(argument.annotation)
            for argument in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)
        }
        for name, description in described(ast.get_docstring(function) or "").items():
            if adds_nothing(name, types.get(name, ""), description):
                found.append(f"{function.lineno}: {function.name}: '{name}: {description}'")
    return found


def test_arguments_are_described_only_where_that_adds_something() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{entry}"
        for path in FILES
        for entry in empty_entries(path.read_text())
    ]
    assert not found, "\n".join(found)


def test_modules_and_packages_say_what_is_in_them() -> None:
    for path in FILES:
        docstring = ast.get_docstring(ast.parse(path.read_text()))
        assert docstring is not None, path
        assert len(docstring.split()) >= 3, f"{path}: {docstring}"


@pytest.mark.parametrize(
    "entry",
    [
        "robot: The robot.",
        "motion: The motion.",
        "path: The path.",
        "task: Name of the task.",
        "weights: All weights.",
    ],
)
def test_what_repeats_a_name_is_found(entry: str) -> None:
    (argument, _) = entry.split(":")
    source = f'def f({argument}):\n    """Do it.\n\n    Args:\n        {entry}\n    """\n'
    assert empty_entries(source)


@pytest.mark.parametrize(
    "entry",
    [
        "weights: (L,) [m/s^2].",
        "tau: Commanded torque, (n,) [N m].",
        "phase: [rad].",
        "seed: Of the noise.",
        "path: The PNG file.",
        "joints: In the order of tau,\n            base first.",
    ],
)
def test_what_adds_something_is_kept(entry: str) -> None:
    (argument, *_) = entry.split(":")
    source = f'def f({argument}):\n    """Do it.\n\n    Args:\n        {entry}\n    """\n'
    assert not empty_entries(source)


def test_a_type_tells_as_much_as_a_name() -> None:
    source = (
        'def f(name: ModelError):\n    """Do it.\n\n    Args:\n        name: Model error.\n    """'
    )
    assert empty_entries(source)
