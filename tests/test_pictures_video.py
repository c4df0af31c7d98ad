"""Films."""

import av
import numpy as np
import pytest

from mien.errors import BadInput
from mien.pictures import (
    write_mp4,
)
from page_parts import flat


def test_film_reads_back(tmp_path):
    path = tmp_path / "film.mp4"
    frames = [np.full((31, 41, 3), (20 * i, 100, 250 - 20 * i), dtype=np.uint8) for i in range(11)]
    assert write_mp4(path, iter(frames), 29.97) == 11
    with av.open(str(path)) as film:
        stream = film.streams.video[0]
        assert (stream.width, stream.height) == (40, 30)
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert stream.codec_context.name == "h264"
        np.testing.assert_allclose(float(stream.average_rate), 29.97, rtol=1e-4)
        back = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(back) == 11
    for frame, image in zip(frames, back, strict=True):
        np.testing.assert_allclose(image.mean((0, 1)), frame[0, 0], atol=6)


def test_a_film_that_fails_leaves_nothing_behind(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_bytes(b"the old one")
    with pytest.raises(BadInput, match="frame 1 has shape"):
        write_mp4(path, [flat(0), flat(0, 22)], 30.0)
    with pytest.raises(BadInput, match="at least one frame"):
        write_mp4(path, [], 30.0)
    with pytest.raises(BadInput, match="rate must be positive"):
        write_mp4(path, [flat(0)], 0.0)
    with pytest.raises(BadInput, match="2 x 2"):
        write_mp4(path, [flat(0, 1, 1)], 30.0)

    def stopped():
        yield flat(0)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_mp4(path, stopped(), 30.0)
    assert path.read_bytes() == b"the old one"
    assert list(tmp_path.iterdir()) == [path]
