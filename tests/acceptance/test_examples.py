import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"


def run(name: str, *arguments: str) -> list[str]:
    """The lines that an example prints, and one of the modules that it loaded."""
    code = (
        "import runpy, sys; sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0]); "
        "print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(EXAMPLES / name), *arguments],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_ten_lines_learn_and_generalise() -> None:
    first, without, generalized, _ = run("ten_lines.py", "0.02", "0.04", "0.03")
    assert first.startswith("OK: knee torque")
    assert without.startswith("without")
    assert generalized.startswith("generalised")
    before, after = (float(line.split()[-2]) for line in (without, generalized))
    assert before > 50 * after


def test_a_plant_of_ones_own_learns_without_mujoco() -> None:
    *lines, modules = run("own_plant.py", "0.03", "0.5")
    none, _, twice = (float(line.split()[-2]) for line in lines)
    assert [line.split(":")[0] for line in lines] == [f"iteration {n}" for n in range(3)]
    assert none > 100 * twice
    assert none > 1000  # um
    assert "pinocchio" in modules.split()
    assert not {"mujoco", "tsd_clients"} & set(modules.split())


def test_the_page_about_plants_does_what_it_says(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "own-plant.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", page, re.M | re.S)
    assert len(blocks) == 2
    program = tmp_path / "page.py"
    program.write_text("\n".join(blocks))
    fell, watched, _ = run(str(program))
    assert re.fullmatch(r"True after 0\.[12]\d s", fell)
    kept, dropped = (int(number) for number in re.findall(r"\d+", watched))
    assert kept == 50
    assert dropped > 50
