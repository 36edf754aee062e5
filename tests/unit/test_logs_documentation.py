import runpy
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def test_page_of_the_logs_is_the_generated_one() -> None:
    generator = runpy.run_path(str(DOCS / "generate_logs.py"))
    assert (DOCS / "logs.md").read_text() == generator["generate"](), (
        "run: python docs/generate_logs.py"
    )
