"""Docstrings as the terminal wants them: paragraphs in one line, examples as they stand."""

from __future__ import annotations

# Typer's mark of a paragraph whose line breaks stay; before each line it saves the
# indentation too, and no terminal gets to see it
AS_IT_STANDS = "\b"


def unwrap(text: str) -> str:
    """Join the lines of each paragraph, so that they break where the terminal ends.

    Args:
        text: A paragraph that begins with the command is examples, one a line.
    """
    return "\n\n".join(
        _examples(paragraph) if paragraph.split()[:1] == ["tsd"] else " ".join(paragraph.split())
        for paragraph in text.strip("\n").split("\n\n")
    )


def _examples(paragraph: str) -> str:
    return "\n".join(f"{AS_IT_STANDS}  {line.strip()}" for line in paragraph.splitlines())
