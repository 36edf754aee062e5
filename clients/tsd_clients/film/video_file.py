"""Films as files: H.264 in MP4, or a GIF that repeats."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.whole_file import check_writable
from tsd_clients.extra import require_extra

Picture = NDArray[np.uint8]

# GIF knows hundredths of a second only, and grows with every picture [pictures/s]
MP4_RATE, GIF_RATE = 25.0, 20.0
ENCODER = "libx264"
# visually lossless for drawn lines, 1 MB a minute at 640 x 480 (x264: 18 to 28 is sane)
QUALITY = {"crf": "20", "preset": "veryfast"}
COLORS = 255  # of a GIF, and one for what does not change
# pictures that its colours are chosen from: every eighth of the first hundred, which
# bounds what is kept of a long film uncompressed
PALETTE_PICTURES, PALETTE_STEP = 100, 8


class VideoFile(Protocol):
    """A film that is being written."""

    def add(self, picture: Picture) -> None:
        """Add a picture, (height, width, 3)."""

    def close(self) -> None:
        """Write what is left."""


class Mp4File:
    """H.264, as players and browsers read it."""

    def __init__(self, file: BinaryIO, width: int, height: int, rate: float) -> None:
        """Begin; width and height are even [pixels]."""
        import av

        self._av = av
        self._container = av.open(file, "w", format="mp4")
        stream: Any = self._container.add_stream(ENCODER, rate=Fraction(rate), options=QUALITY)
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        self._stream = stream

    def add(self, picture: Picture) -> None:
        """Add a picture, (height, width, 3)."""
        frame = self._av.VideoFrame.from_ndarray(picture, format="rgb24")
        self._container.mux(self._stream.encode(frame))

    def close(self) -> None:
        """Write what is left."""
        self._container.mux(self._stream.encode())
        self._container.close()


class GifFile:
    """A GIF that repeats for ever, with one palette: otherwise what is at rest would flicker."""

    def __init__(self, file: BinaryIO, rate: float) -> None:
        """Begin."""
        self._file, self._duration = file, 10 * round(100 / rate)  # ms
        self._waiting: list[Picture] = []
        self._pictures: list[Any] = []
        self._palette: Any = None

    def add(self, picture: Picture) -> None:
        """Add a picture, (height, width, 3)."""
        self._waiting.append(picture)
        if len(self._waiting) >= PALETTE_PICTURES or self._palette is not None:
            self._reduce()

    def close(self) -> None:
        """Write it."""
        self._reduce()
        first, *others = self._pictures
        first.save(
            self._file,
            "GIF",
            save_all=True,
            append_images=others,
            duration=self._duration,
            loop=0,
            optimize=True,
        )

    def _reduce(self) -> None:
        """Give what waits the palette's colours."""
        from PIL import Image

        if self._palette is None:
            sample = np.concatenate(self._waiting[::PALETTE_STEP], axis=1)
            self._palette = Image.fromarray(sample).quantize(COLORS)
        self._pictures += [
            Image.fromarray(each).quantize(palette=self._palette, dither=Image.Dither.NONE)
            for each in self._waiting
        ]
        self._waiting.clear()


RATES = {".mp4": MP4_RATE, ".gif": GIF_RATE}


def rate_of(path: str | Path) -> float:
    """Tell how many pictures a second a film has [1/s].

    Raises:
        InvalidValue: If its ending is not the one of a film.
    """
    ending = Path(path).suffix.lower()
    if ending not in RATES:
        raise InvalidValue("film", f"'{path}'", f"a name that ends in {' or '.join(RATES)}")
    return RATES[ending]


def check_film_path(path: str | Path) -> None:
    """Refuse a film that could not be written, before the work.

    Raises:
        InvalidValue: If the ending is none of a film's, or the file cannot be written.
        NotAvailable: If the libraries for it are not installed.
    """
    rate_of(path)
    check_writable(path)
    require_extra("view", "a film", "av", "fast_simplification")


def open_video(file: BinaryIO, path: str | Path, width: int, height: int) -> VideoFile:
    """Begin a film whose name's ending says what it is.

    Args:
        file: What it is written to.
        width: Even [pixels].
        height: Even [pixels].

    Raises:
        InvalidValue: If the ending is none of a film's.
    """
    rate = rate_of(path)
    if Path(path).suffix.lower() == ".gif":
        return GifFile(file, rate)
    return Mp4File(file, width, height, rate)
