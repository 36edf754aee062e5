import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


def test_wire_page_is_the_generated_one() -> None:
    # older ones write the same schema in other words
    pytest.importorskip("pydantic", minversion="2.11")
    generator = runpy.run_path(str(DOCS / "generate_wire.py"))
    assert (DOCS / "wire.md").read_text() == generator["generate"](), (
        "run: python docs/generate_wire.py"
    )
