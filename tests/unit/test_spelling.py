"""One spelling: names in code are American, prose is British (docs/glossary.md)."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CODE = (
    "binding",
    "tsd_casadi",
    "models",
    "server",
    "clients",
    "experiments",
    "cli",
    "benchmarks",
    "docs",
    "examples",
    "tests",
)
PYTHON = sorted(path for folder in CODE for path in (ROOT / folder).rglob("*.py"))
C = sorted(
    path
    for folder in ("tsd_casadi", "binding")
    for path in (ROOT / folder).rglob("*")
    if path.suffix in {".c", ".h", ".cpp", ".hpp"}
)
PAGES = sorted(
    [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "models").rglob("*.md")]
)

# from Python 3.12 on the text of an f-string is a token of its own
STRINGS = {tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING)}
# parts of a name, which is why they match anywhere in it
BRITISH = re.compile(
    r"(?i)centre|behaviour|colour|neighbour|favour|grey|metres?(?![a-z])|modell|labell|cancell"
    r"|analys(?!is|es)|synthesis(?!_|$)"
    r"|(?:general|initial|normal|optim|minim|maxim|linear|factor|regular|standard|summar|quant"
    r"|discret|synchron|organ|recogn|real|util|visual|parametr|symmetr|random|penal|stabil"
    r"|serial)is(?:e|ing|ation)"
)
AMERICAN = re.compile(
    r"(?i)\b(?:center(?:s|ed|ing)?|behaviors?|colors?|colored|neighbors?|neighboring|favors?|gray"
    r"|(?:milli|centi|kilo)?meters?|model(?:ed|ing)|label(?:ed|ing)|cancel(?:ed|ing)"
    r"|analyz(?:e|es|ed|ing)|(?!re?size|size|prize|seize)\w+iz(?:e|es|ed|er|ing|ations?))\b"
)
# Names of fields on the wire are what they are; names of tests are sentences, and so prose.
KEPT = re.compile(r"centres|test_\w+")
# What is no prose in a text: code in backticks, labels of equations, an attribute that is
# described, quoted words, a string's placeholders, places in a figure and its colours.
CODE_IN_TEXT = re.compile(
    r"`+[^`]*`+|\[\w+\]|^\| generalization \||^ +\w+: |\"[^\"\s]+\"|'[^'\s]+'|\{[^{}]*\}"
    r"|upper center|color: #\w+|style='[^']*",
    re.MULTILINE,
)
# Names and paths: with a dot, underscore, slash or capital inside, called, or an option.
NAME_IN_TEXT = re.compile(
    r"https?://\S+|\w*(?:[._/=]\w+)+[._/]?|\w+(?:::|\()|[A-Z]?[a-z]+[A-Z]\w*|--[\w-]+"
)


def names(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Everything that is given a name: functions, classes, arguments, variables, attributes."""
    for node in ast.walk(tree):
        line = getattr(node, "lineno", 1)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield line, node.name
        elif isinstance(node, ast.arg):
            yield line, node.arg
        elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield line, node.id if isinstance(node, ast.Name) else node.attr


def british_names(path: Path) -> list[str]:
    found = [(1, part) for part in path.relative_to(ROOT).parts]
    found += names(ast.parse(path.read_text()))
    return [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for line, name in found
        if BRITISH.search(name) and not KEPT.fullmatch(name)
    ]


def python_prose(source: str) -> Iterator[tuple[int, str]]:
    """Comments, and strings of several words: docstrings and messages."""
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        is_string = token.type in STRINGS and " " in token.string
        if token.type == tokenize.COMMENT or is_string:
            yield token.start[0], token.string


def c_prose(source: str) -> Iterator[tuple[int, str]]:
    for comment in re.finditer(r"/\*.*?\*/|//[^\n]*", source, re.DOTALL):
        yield source.count("\n", 0, comment.start()) + 1, comment[0]


def page_prose(source: str) -> Iterator[tuple[int, str]]:
    """Lines outside of blocks of code."""
    is_code = False
    for number, line in enumerate(source.splitlines(), 1):
        if line.lstrip().startswith("```"):
            is_code = not is_code
        elif not is_code:
            yield number, line


def american_words(text: str) -> list[str]:
    """American words that are no names."""
    return AMERICAN.findall(NAME_IN_TEXT.sub(" ", CODE_IN_TEXT.sub(" ", text)))


def american_prose(path: Path) -> list[str]:
    source = path.read_text()
    prose = {".py": python_prose, ".md": page_prose}.get(path.suffix, c_prose)
    return [
        f"{path.relative_to(ROOT)}:{line}: {', '.join(words)}"
        for line, text in prose(source)
        if (words := american_words(text))
    ]


def test_names_are_american() -> None:
    found = [name for path in PYTHON for name in british_names(path)]
    assert not found, "\n".join(found)


def test_prose_is_british() -> None:
    own = Path(__file__).resolve()
    read = (path for path in (*PYTHON, *C, *PAGES) if path.resolve() != own)
    found = [words for path in read for words in american_prose(path)]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("name", "is_british"),
    [
        ("generalise", True),
        ("compare_generalised", True),
        ("millimetres", True),
        ("centre_of_mass", True),
        ("analyse", True),
        ("center_of_mass", False),
        ("parameters", False),
        ("analysis", False),
        ("noise_of_minimum", False),
        ("raised", False),
    ],
)
def test_british_names_are_found(name: str, is_british: bool) -> None:
    assert bool(BRITISH.search(name)) is is_british


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("The center of mass, generalized.", 2),
        ("Behavior near 3 meters", 2),
        ("Optimized for the size of a horizon that was seized and resized", 1),
        ("# see `center_of_mass` and ``GENERALIZED``, [generalization]", 0),
        ("    center: Of the sole [m].", 0),
        ("tsd_casadi/generalization/suggestion.py sets robot.center", 0),
        ("the parameter's analysis", 0),
    ],
)
def test_american_words_are_found(text: str, count: int) -> None:
    assert len(american_words(text)) == count
