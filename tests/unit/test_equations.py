"""The table of equations and the modules' first lines say the same."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^\| (?P<label>[\w-]+) \| `(?P<file>[\w/]+\.py)` \|$", re.MULTILINE)
LABELS = re.compile(r"\[([\w-]+(?:, [\w-]+)*)\]\.?$")


def in_table() -> set[tuple[str, str]]:
    rows = ROW.findall((ROOT / "docs" / "equations.md").read_text())
    assert len(rows) >= 14
    return set(rows)


def in_modules() -> set[tuple[str, str]]:
    found = set()
    for path in (ROOT / "tsd_casadi").rglob("*.py"):
        first = (ast.get_docstring(ast.parse(path.read_text())) or "").partition("\n")[0]
        match = LABELS.search(first)
        labels = match[1].split(", ") if match else []
        found |= {(label, str(path.relative_to(ROOT))) for label in labels}
    return found


def test_every_equation_of_the_table_is_named_by_its_module() -> None:
    assert in_table() == in_modules()
