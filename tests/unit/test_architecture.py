"""What the layers' tool cannot see: roots, exports, the listing that the docs describe."""

import ast
import importlib
import re
from collections.abc import Collection
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = {
    "tsd_casadi": ROOT / "tsd_casadi",
    "tsd_clients": ROOT / "clients" / "tsd_clients",
    "tsd_server": ROOT / "server" / "tsd_server",
    "tsd_experiments": ROOT / "experiments" / "tsd_experiments",
    "tsd_cli": ROOT / "cli" / "tsd_cli",
}
SOURCES = [path for folder in PACKAGES.values() for path in sorted(folder.rglob("*.py"))]


def imported(path: Path) -> set[str]:
    """Modules that a file imports, also inside functions."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names.add(str(node.module))
    return names


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_module_of_ours_imports_a_root(path: Path) -> None:
    assert not imported(path) & set(PACKAGES)


@pytest.mark.parametrize("package", PACKAGES)
def test_what_a_root_exports_is_there(package: str) -> None:
    root = importlib.import_module(package)
    for name in getattr(root, "__all__", []):
        assert getattr(root, name) is not None


def test_the_public_names() -> None:
    """Adding one is a decision, taking one away breaks programs: both are made here as well."""
    exported = {
        name: sorted(getattr(importlib.import_module(name), "__all__", [])) for name in PACKAGES
    }
    assert exported == {
        "tsd_casadi": [
            "Command",
            "Controller",
            "Database",
            "Feedforward",
            "Gains",
            "InverseDynamics",
            "Motion",
            "PeriodicBasis",
            "Plant",
            "Robot",
            "Run",
            "Squat",
            "State",
            "Status",
            "Tick",
            "Truth",
            "TsdError",
            "WholeBodyController",
            "__version__",
            "compile_controller",
            "learn",
            "load_robot",
            "repeat",
        ],
        "tsd_clients": [
            "ModelError",
            "MujocoSimulator",
            "RemoteController",
            "RemoteLearner",
            "save_log",
        ],
        "tsd_server": ["ControllerService", "LearnerService", "ServiceProcess"],
        "tsd_experiments": [],
        "tsd_cli": [],
    }


def test_few_modules_stand_alone() -> None:
    alone = {path.stem for path in PACKAGES["tsd_casadi"].glob("*.py")} - {"__init__"}
    assert len(alone) <= 6, sorted(alone)


def test_clients_of_the_services_are_a_small_part() -> None:
    # whoever brings another simulator or robot writes these anew; looking at runs is the same
    # for all of them
    looking = {"film", "logs", "telemetry", "viewer"}

    def lines(folder: Path, without: Collection[str] = ()) -> int:
        files = (p for p in folder.rglob("*.py") if p.relative_to(folder).parts[0] not in without)
        return sum(len(path.read_text().splitlines()) for path in files)

    everything = sum(lines(folder) for folder in PACKAGES.values())
    assert lines(PACKAGES["tsd_clients"], looking) <= 0.15 * everything


def test_the_architecture_page_names_every_room() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text()
    rooms = {
        path.name
        for package in ("tsd_casadi", "tsd_clients", "tsd_experiments")
        for path in PACKAGES[package].iterdir()
        if (path / "__init__.py").is_file()
    }
    missing = {room for room in rooms if f"`{room}/`" not in page}
    assert not missing


def test_files_that_the_docs_name_are_there() -> None:
    mentioned = re.compile(
        r"`((?:tsd_casadi|clients|server|cli|experiments|tests|models|binding|benchmarks|examples|docs)/[\w./-]+)`"
    )
    for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]:
        for name in mentioned.findall(page.read_text()):
            if not re.search(r"NAME|QUESTION|_N_", name):  # what a recipe leaves open
                assert (ROOT / name).exists(), f"{page.name}: {name}"
