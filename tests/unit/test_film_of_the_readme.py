from __future__ import annotations

from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[2]
FILM = ROOT / "docs" / "g1_learning.gif"


def test_the_readme_opens_with_a_film_that_loads_quickly() -> None:
    head = (ROOT / "README.md").read_text()[:400]
    assert "docs/g1_learning.gif" in head
    assert FILM.stat().st_size <= 3e6
    with Image.open(FILM) as film:
        seconds = 0.0
        for place in range(film.n_frames):
            film.seek(place)
            seconds += film.info["duration"] / 1e3
    assert 6 <= seconds <= 10


def test_the_readme_names_the_command_that_makes_it() -> None:
    assert "`python docs/film_learning.py`" in (ROOT / "README.md").read_text()
    assert (ROOT / "docs" / "film_learning.py").is_file()
