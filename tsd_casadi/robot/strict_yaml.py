"""YAML without its surprises: what it would silently read as something else is refused by line.

YAML 1.1 reads 010 as 8, 1:30 as 90, an unquoted 'on' or 'no' as a truth value, and the
last of two equal keys as the only one. In a robot file each of these is a mistake.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from tsd_casadi.exceptions import RobotFileError

# a robot with a hundred joints, each with every override, takes 50 kB
LARGEST_FILE = 1_000_000  # bytes
# sections of a robot file are four levels deep
DEEPEST = 20
# more than a file of that size holds without aliases
MOST_NODES = 500_000

_EXPONENT = re.compile(r"^[-+]?[0-9]+[eE][-+]?[0-9]+$")
_OCTAL = re.compile(r"^[-+]?0[0-9_]+$")
_SEXAGESIMAL = re.compile(r"^[-+]?[0-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?$")
_TRUTH = re.compile(r"^(yes|no|on|off)$", re.IGNORECASE)

# what descriptions of links and joints begin with, after comments
_DESCRIPTIONS = {"<robot": "a URDF", "<mujoco": "an MJCF"}


class _Surprise(Exception):
    """What a line holds that would be read as something else."""

    def __init__(self, line: int, found: str, expected: str) -> None:
        super().__init__(found)
        self.field = f"line {line}"
        self.found = found
        self.expected = expected


class _Loader(yaml.SafeLoader):
    """YAML 1.1, but 1e-6 is a number as everywhere else, and nothing is guessed."""

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Refuse deep nesting."""
        event = self.peek_event()  # type: ignore[no-untyped-call]
        line = event.start_mark.line + 1
        self._depth += 1
        if self._depth > DEEPEST:
            raise _Surprise(line, "is nested too deeply", f"at most {DEEPEST} levels")
        try:
            return super().compose_node(parent, index)
        finally:
            self._depth -= 1

    def get_single_data(self) -> Any:
        """Refuse aliases of aliases, which grow without bound when they are looked at."""
        node = self.get_single_node()
        if node is None:
            return None
        _expanded_size(node, {})
        return self.construct_document(node)

    def construct_mapping(self, node: Any, deep: bool = False) -> Any:
        """Refuse two equal keys."""
        lines: dict[Any, int] = {}
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            line = key_node.start_mark.line + 1
            if key in lines:
                found = f"'{key}' is there already, in line {lines[key]}"
                raise _Surprise(line, found, "each name once")
            lines[key] = line
        return super().construct_mapping(node, deep)

    def construct_plain(self, node: Any) -> Any:
        """Construct what is not quoted, unless it would not be what it looks like."""
        text, line = node.value, node.start_mark.line + 1
        if node.style is None:
            if _TRUTH.match(text):
                raise _Surprise(line, f"{text} without quotes is a truth value", f'"{text}"')
            if _OCTAL.match(text) and text.strip("+-0_"):
                decimal = text.lstrip("+-").lstrip("0_")
                raise _Surprise(line, f"{text} is an octal number", f"{decimal} or a decimal point")
            if _SEXAGESIMAL.match(text):
                raise _Surprise(
                    line, f"{text} is a number to the base of 60", f'a decimal number or "{text}"'
                )
        return _BY_TAG[node.tag](self, node)


def _expanded_size(node: Any, known: dict[int, int]) -> int:
    """Count the nodes below one, those behind aliases each time.

    Args:
        known: Sizes by identity of those that were counted; zero while one is.
    """
    if id(node) in known:
        if not known[id(node)]:
            raise _Surprise(node.start_mark.line + 1, "is an alias of what it is in", "no circle")
        return known[id(node)]
    known[id(node)] = 0
    children = [] if isinstance(node.value, str) else node.value
    flat = [each for child in children for each in (child if isinstance(child, tuple) else [child])]
    size = 1 + sum(_expanded_size(child, known) for child in flat)
    if size > MOST_NODES:
        line = node.start_mark.line + 1
        raise _Surprise(line, "is an alias of too many aliases", "what they stand for, written out")
    known[id(node)] = size
    return size


_BY_TAG = {
    f"tag:yaml.org,2002:{kind}": getattr(yaml.SafeLoader, f"construct_yaml_{kind}")
    for kind in ("bool", "int", "float", "str")
}
for _tag in _BY_TAG:
    _Loader.add_constructor(_tag, _Loader.construct_plain)
_Loader.add_implicit_resolver("tag:yaml.org,2002:float", _EXPONENT, list("-+0123456789"))


def read_yaml(path: Path) -> dict[str, Any]:
    """Read a mapping from a YAML file.

    Returns:
        Plain data.

    Raises:
        RobotFileError: If the file cannot be read, is larger than a megabyte, no
            YAML, no mapping, or holds something that YAML would read as something
            else; the line is named.
    """
    try:
        with path.open("rb") as file:
            # not by its size on the disk: a pipe or a device has none
            content = file.read(LARGEST_FILE + 1)
        text = content.decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RobotFileError(path, "", f"cannot be read ({error})", "a YAML file") from error
    _refuse_description(path, text)
    if len(content) > LARGEST_FILE:
        raise RobotFileError(
            path, "", "is too large for a robot file", f"at most {LARGEST_FILE / 1e6:g} MB of YAML"
        )
    try:
        document: Any = yaml.load(text, _Loader)
    except _Surprise as error:
        raise RobotFileError(path, error.field, error.found, error.expected) from None
    except Exception as error:  # besides YAMLError all that int(), datetime and depth raise
        reason = " ".join(str(error).split())
        expected = _without_tab(text, error) or "a YAML file"
        raise RobotFileError(path, "", f"is not YAML ({reason})", expected) from error
    if not isinstance(document, dict):
        raise RobotFileError(path, "", "holds no mapping", "fields such as 'name', 'urdf'")
    return document


def _refuse_description(path: Path, text: str) -> None:
    """Refuse the description of links and joints where the robot file is asked for.

    Raises:
        RobotFileError: If it is one.
    """
    if not text.lstrip("\ufeff \t\r\n").startswith("<"):
        return
    kind = next((kind for mark, kind in _DESCRIPTIONS.items() if mark in text), "XML")
    raise RobotFileError(
        path,
        "",
        f"is {kind}, no robot file",
        f"a robot file, YAML; 'tsd robot new {path} --feet LEFT,RIGHT' writes one for it",
    )


def _without_tab(text: str, error: Exception) -> str:
    """Name the line that a tab makes no YAML; empty if none does."""
    mark = getattr(error, "problem_mark", None)
    lines = text.split("\n")
    if mark is None or mark.line >= len(lines):
        return ""
    line = lines[mark.line]
    indentation = line[: len(line) - len(line.lstrip())]
    if "\t" not in indentation + line[mark.column : mark.column + 1]:
        return ""
    return f"spaces where line {mark.line + 1} has a tab"
