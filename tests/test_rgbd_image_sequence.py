"""Single frames of a film, by time."""

import pytest

from grey_film import film
from mien.errors import BadInput
from mien.rgbd.image_sequence import read_stills


def test_stills_are_the_frames_on_screen(tmp_path):
    path = film(tmp_path / "f.mp4", 50)
    stills = read_stills(path, [3.05, 0.0, 1.51, 4.99])
    grey = [round(float(s.mean()) / 4) for s in stills]
    assert grey == [30, 0, 15, 49]


def test_times_outside_the_film_and_other_files_are_named(tmp_path):
    path = film(tmp_path / "f.mp4", 20)
    with pytest.raises(BadInput, match="before the film begins"):
        read_stills(path, [0.5, -0.1])
    with pytest.raises(BadInput, match=r"no frame at 2\.20 s, it lasts 2\.00 s"):
        read_stills(path, [2.2])
    (tmp_path / "no.mp4").write_text("no film")
    with pytest.raises(BadInput, match="no film"):
        read_stills(tmp_path / "no.mp4", [0.0])
