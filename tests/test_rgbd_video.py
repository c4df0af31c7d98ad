"""Videos as takes without depth."""

from fractions import Fraction

import av
import numpy as np
import pytest

from mien.errors import BadInput
from mien.rgbd import read_rgbd
from rgbd_takes import made


def test_video_alone_assumes_sixty_degrees(tmp_path):
    path = tmp_path / "clip.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = 48, 32, "yuv420p"
        for frame in made(5):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame.color, format="rgb24")))
        container.mux(stream.encode(None))
    take = read_rgbd(path)
    frames = list(take)
    assert (len(frames), take.count, take.rate, take.has_depth, take.guessed_camera) == (5, 5, 25.0, False, True)
    assert take.camera.fx == pytest.approx(24 / np.tan(np.radians(30)))
    np.testing.assert_allclose([f.time for f in frames], np.arange(5) / 25, atol=1e-3)
    assert np.abs(frames[2].color.astype(int) - list(made(5))[2].color).mean() < 6


def test_frames_that_come_unevenly_fill_the_time_they_took_and_are_told_of(tmp_path):
    """Matroska states the rate that a phone meant, here twice the one it kept."""
    path, ticks = tmp_path / "clip.mkv", [0, 40, 80, 120, 280, 320, 360, 720]
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = 48, 32, "yuv420p"
        stream.codec_context.time_base = Fraction(1, 1000)
        for frame, tick in zip(made(8), ticks, strict=True):
            picture = av.VideoFrame.from_ndarray(frame.color, format="rgb24")
            picture.pts, picture.time_base = tick, Fraction(1, 1000)
            container.mux(stream.encode(picture))
        container.mux(stream.encode(None))
    take = read_rgbd(path)
    assert take.rate == pytest.approx(7 / 0.72, rel=0.01)
    assert "its frames come unevenly" in take.notes[0]
    np.testing.assert_allclose([f.time for f in take], np.array(ticks) / 1000, atol=2e-3)


def test_a_file_that_is_no_video(tmp_path):
    (tmp_path / "a.mp4").write_bytes(b"no")
    with pytest.raises(BadInput, match="no video that can be read"):
        read_rgbd(tmp_path / "a.mp4")
