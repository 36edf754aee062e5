"""What a client on a robot loads, seen in fresh interpreters: nothing that takes a second."""

from __future__ import annotations

import os
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


def test_commands_load_without_what_the_extras_bring() -> None:
    extras = {
        "av",
        "example_robot_data",
        "fast_simplification",
        "mcap",
        "rosbags",
        "viser",
        "xacro",
    }
    loaded = loaded_by(LOAD, "tsd_cli")
    assert "typer" in loaded
    assert not loaded & extras


# prints what BLAS will read at the moment in which numpy is asked for
THREADS = """
import os, runpy, sys

class Watch:
    def find_spec(self, name, path=None, target=None):
        if name == "numpy":
            print(*(os.environ.get(each) for each in variables))
            sys.meta_path.remove(self)

sys.meta_path.insert(0, Watch())
variables, program, arguments = sys.argv[1].split(","), sys.argv[2], sys.argv[3:]
sys.argv = [program, *arguments]
runpy.run_module(program, run_name="__main__")
"""
VARIABLES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")


@pytest.mark.parametrize(
    ("program", "arguments"),
    # both refuse; numpy is loaded by then
    [("tsd_server", ["learner", "--listen", "x"]), ("tsd_cli", ["motion", "show", "x"])],
)
@pytest.mark.parametrize("users", [None, "3"])
def test_programs_use_one_thread_for_linear_algebra(
    program: str, arguments: list[str], users: str | None
) -> None:
    environment = {name: text for name, text in os.environ.items() if name not in VARIABLES}
    if users is not None:
        environment["OMP_NUM_THREADS"] = users
    done = subprocess.run(
        [sys.executable, "-c", THREADS, ",".join(VARIABLES), program, *arguments],
        capture_output=True,
        text=True,
        env=environment,
    )
    expected = ["1", "1", "1"] if users is None else ["None", "None", users]
    assert done.stdout.split() == expected, done.stderr


def test_a_list_of_the_database_loads_no_robot() -> None:
    code = "import sys, tsd_cli.actions.entries; print(*sys.modules)"
    assert not loaded_by(code) & HEAVY
