from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tsd_casadi.exceptions import InvalidValue, NotAvailable
from tsd_clients import extra
from tsd_clients.film.video_file import (
    GIF_RATE,
    MP4_RATE,
    PALETTE_PICTURES,
    Picture,
    check_film_path,
    open_video,
)

WIDTH, HEIGHT = 64, 48


def _moving(count: int) -> list[Picture]:
    """A white bar that goes from left to right over red."""
    pictures = []
    for place in range(count):
        picture = np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)
        picture[:, :, 0] = 200
        left = (WIDTH - 8) * place // count
        picture[:, left : left + 8] = 255
        pictures.append(picture)
    return pictures


def _write(path: Path, pictures: list[Picture]) -> None:
    with path.open("wb") as file:
        video = open_video(file, path, WIDTH, HEIGHT)
        for picture in pictures:
            video.add(picture)
        video.close()


def test_an_mp4_has_every_picture_at_its_rate(tmp_path: Path) -> None:
    import av

    path, pictures = tmp_path / "film.mp4", _moving(30)
    _write(path, pictures)
    with av.open(path) as found:
        (stream,) = found.streams.video
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert float(stream.duration * stream.time_base) == pytest.approx(30 / MP4_RATE)
        read = [frame.to_ndarray(format="rgb24") for frame in found.decode(video=0)]
    assert len(read) == 30
    for picture, again in zip(pictures, read, strict=True):
        assert np.abs(picture.astype(float) - again).mean() < 20  # colours at half the resolution


@pytest.mark.parametrize("count", [3, PALETTE_PICTURES + 3])
def test_a_gif_has_every_picture_and_repeats(tmp_path: Path, count: int) -> None:
    path, pictures = tmp_path / "film.gif", _moving(count)
    _write(path, pictures)
    with Image.open(path) as found:
        assert found.info["loop"] == 0
        shown, seconds = 0, 0.0
        for place in range(found.n_frames):
            found.seek(place)
            duration = found.info["duration"] / 1e3
            # a picture like the one before is the same one for longer
            again = np.asarray(found.convert("RGB"), dtype=float)
            assert np.abs(pictures[shown].astype(float) - again).max() < 8
            shown += round(duration * GIF_RATE)
            seconds += duration
        assert seconds == pytest.approx(count / GIF_RATE)


@pytest.mark.parametrize("name", ["film.avi", "film", "film.mp4.txt"])
def test_another_ending_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InvalidValue, match=r"ends in \.mp4 or \.gif"):
        check_film_path(tmp_path / name)
    with pytest.raises(InvalidValue, match=r"ends in \.mp4 or \.gif"):
        open_video(io.BytesIO(), name, WIDTH, HEIGHT)


def test_a_folder_that_is_not_there_is_told_before_the_work(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match="there is no folder"):
        check_film_path(tmp_path / "nowhere" / "film.mp4")


def test_a_missing_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extra, "find_spec", lambda name: None if name == "av" else object())
    with pytest.raises(NotAvailable, match=r"a film needs av, .* pip install 'tsd_casadi\[view\]'"):
        check_film_path(tmp_path / "film.mp4")
