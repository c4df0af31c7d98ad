import io

import av
import numpy as np
import pytest
from PIL import Image

from mien.errors import BadInput
from mien.viewer.kept.film_out import FilmOut, free_name


def jpeg(level):
    buffer = io.BytesIO()
    Image.fromarray(np.full((48, 64, 3), level, np.uint8)).save(buffer, format="jpeg")
    return buffer.getvalue()


def test_frames_become_a_film_and_the_next_one_spares_it(tmp_path):
    out = FilmOut(tmp_path / "perf.glb")
    for _ in range(2):
        for level in (40, 120, 200):
            out.add(jpeg(level), {"film": "a"})
        out.finish(b"", {"film": "a", "rate": "30"})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["perf.mp4", "perf_2.mp4"]
    with av.open(tmp_path / "perf.mp4") as film:
        levels = [frame.to_ndarray(format="rgb24").mean() for frame in film.decode(video=0)]
    np.testing.assert_allclose(levels, [40, 120, 200], atol=6)


def test_a_film_without_frames_is_told(tmp_path):
    with pytest.raises(BadInput, match="no frames"):
        FilmOut(tmp_path / "perf.glb").finish(b"", {"film": "b", "rate": "30"})
    assert free_name(tmp_path / "a.mp4").name == "a.mp4"
