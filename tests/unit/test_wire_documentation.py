import runpy
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def test_wire_page_is_the_generated_one() -> None:
    generator = runpy.run_path(str(DOCS / "generate_wire.py"))
    assert (DOCS / "wire.md").read_text() == generator["generate"](), (
        "run: python docs/generate_wire.py"
    )
