"""What a client on a robot loads, seen in fresh interpreters: nothing that takes a second."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = {"casadi", "pinocchio", "mujoco", "scipy", "sklearn", "matplotlib"}
PACKAGES = ("tick", "controller", "wire", "encoding", "learning", "generalization", "database")

LOAD = """
import importlib, pkgutil, sys
package = importlib.import_module(sys.argv[1])
for module in pkgutil.walk_packages(package.__path__, f"{sys.argv[1]}."):
    importlib.import_module(module.name)
print(*{name.partition(".")[0] for name in sys.modules})
"""


def loaded_by(code: str, *arguments: str) -> set[str]:
    """Top-level packages in a fresh interpreter after some code that prints them."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True
    )
    return set(done.stdout.split())


@pytest.mark.parametrize("package", PACKAGES)
def test_every_module_of_a_light_package_loads_without_heavy_ones(package: str) -> None:
    loaded = loaded_by(LOAD, f"tsd_casadi.{package}")
    assert "numpy" in loaded
    assert not loaded & HEAVY


def test_the_root_loads_nothing_before_it_is_used() -> None:
    code = 'import sys, tsd_casadi; print(*{name.partition(".")[0] for name in sys.modules})'
    loaded = loaded_by(code)
    assert "tsd_casadi" in loaded
    assert not loaded & {*HEAVY, "numpy", "pydantic"}


def test_the_loop_loads_its_robot_but_no_statistics() -> None:
    code = "import sys, tsd_casadi.repetition.learn; print(*sys.modules)"
    assert not loaded_by(code) & (HEAVY - {"pinocchio"})
