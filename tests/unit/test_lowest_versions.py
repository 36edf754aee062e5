import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
BOUND = re.compile(r"([\w.-]+)(?:>=|==)([\d.]+)(,<[\d.]+)?")


def bounds() -> dict[str, str]:
    """Lowest version by name, of everything that the project may need."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"].values()
    lowest: dict[str, str] = {}
    for requirement in (*project["dependencies"], *(name for extra in extras for name in extra)):
        if requirement.startswith(f"{project['name']}["):
            continue  # one extra that brings another
        match = BOUND.fullmatch(requirement)
        assert match, f"{requirement}: a lower bound is missing"
        name, version, _ = match.groups()
        assert lowest.setdefault(name.lower(), version) == version, f"{name}: two lower bounds"
    return lowest


def test_versions_that_are_tested_are_the_lowest_that_are_allowed() -> None:
    lines = (ROOT / ".ci" / "lowest.txt").read_text().splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert pins == sorted(f"{name}=={version}" for name, version in bounds().items())
