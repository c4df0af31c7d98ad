"""An RGB-D take's pictures as a film."""

import av
import pytest

from mien.errors import BadInput
from mien.rgbd import write_rgbd
from mien.viewer.open_files import gather
from mien.viewer.take_film import film_of, has_film
from rgbd_takes import made


def test_a_folder_of_colour_and_depth_is_a_film_of_its_rate(tmp_path):
    write_rgbd(tmp_path / "take", made(count=5, rate=20.0))
    _, (film,) = gather([tmp_path / "take"])
    assert film.name == "take"
    with av.open(str(film.path)) as shown:
        stream = shown.streams.video[0]
        assert (stream.frames, float(stream.average_rate)) == (5, 20.0)


def test_what_a_browser_plays_is_left_as_it_is(tmp_path):
    (tmp_path / "a.mp4").write_bytes(b"")
    assert film_of(tmp_path / "a.mp4").path == tmp_path / "a.mp4"
    (tmp_path / "b.mkv").write_bytes(b"none")
    assert has_film(tmp_path / "b.mkv")
    with pytest.raises(BadInput, match=r"b\.mkv"):
        film_of(tmp_path / "b.mkv")
    assert not has_film(tmp_path)
