"""Robots as data: one folder each, with a robot file of the same name."""

from __future__ import annotations

from pathlib import Path

__all__ = ["robot_files"]


def robot_files() -> dict[str, Path]:
    """Find the shipped robots.

    Returns:
        Robot file by robot name, sorted by name.
    """
    folder = Path(__file__).parent
    found = (path / f"{path.name}.yaml" for path in sorted(folder.iterdir()) if path.is_dir())
    return {path.stem: path for path in found if path.is_file()}
