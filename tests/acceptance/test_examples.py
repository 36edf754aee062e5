import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_ten_lines_learn_and_generalise() -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / "ten_lines.py"), "0.02", "0.04", "0.03"],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    first, without, generalized = done.stdout.splitlines()
    assert first.startswith("OK: knee torque")
    assert without.startswith("without")
    assert generalized.startswith("generalised")
    before, after = (float(line.split()[-2]) for line in (without, generalized))
    assert before > 50 * after
