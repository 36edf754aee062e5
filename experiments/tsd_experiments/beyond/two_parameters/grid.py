"""The amplitudes and frequencies that are learned, held out, driven and shown."""

from __future__ import annotations

from dataclasses import dataclass

Point = tuple[float, float]  # amplitude [m], frequency [Hz]

NAMES = ("amplitude", "frequency")


@dataclass(frozen=True)
class Grid:
    """Points of amplitude [m] and frequency [Hz].

    Attributes:
        learned: What predictions are made from, the four corners first.
        held_out: What is predicted.
        driven: Of them those where predictions are driven as well.
        shown: Of them those whose curves are drawn.
        repeated: Learned once more with other sensor noise.
        iterations: Learning iterations of each entry.
        draws: Other choices of what is learned and what is held out.
    """

    learned: tuple[Point, ...]
    held_out: tuple[Point, ...]
    driven: tuple[Point, ...]
    shown: tuple[Point, ...]
    repeated: tuple[Point, ...]
    iterations: int = 5
    draws: int = 20

    @property
    def all(self) -> tuple[Point, ...]:
        """Everything that is learned directly."""
        return (*self.learned, *self.held_out)

    @property
    def corners(self) -> tuple[Point, ...]:
        """What no choice of entries is without."""
        return self.learned[:4]


_HELD_OUT: tuple[Point, ...] = tuple(
    (amplitude, frequency)
    for amplitude in (0.036, 0.044, 0.05, 0.058, 0.066, 0.076)
    for frequency in (0.22, 0.26, 0.31, 0.37, 0.45, 0.52)
)
GRID = Grid(
    # corners, middles of the edges, and the middles of the quarters
    learned=(
        (0.03, 0.2),
        (0.03, 0.6),
        (0.08, 0.2),
        (0.08, 0.6),
        (0.055, 0.2),
        (0.055, 0.6),
        (0.03, 0.4),
        (0.08, 0.4),
        (0.0425, 0.3),
        (0.0425, 0.5),
        (0.0675, 0.3),
        (0.0675, 0.5),
    ),
    held_out=_HELD_OUT,
    # black fields of the board
    driven=tuple(point for i, point in enumerate(_HELD_OUT) if (i + i // 6) % 2 == 0),
    # slow and small, in the middle, fast and large
    shown=(_HELD_OUT[0], _HELD_OUT[15], _HELD_OUT[-1]),
    repeated=((0.03, 0.2), (0.0425, 0.3), (0.0675, 0.5), (0.08, 0.6)),
)
