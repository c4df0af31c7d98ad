"""Options in groups: pages have names, and how a take is read is heeded or refused."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mien.cli.options import verb
from mien.cli.shared_options import Pages, PicturesReading, read_pictures
from mien.errors import BadInput


def test_pages_have_the_outputs_name_unless_told():
    named = Pages(report=Path("other.html")).named_by(Path("out/perf.glb"))
    assert named.outputs == {"a picture": Path("out/perf.png"), "a page": Path("other.html")}


@pytest.fixture
def pictures(tmp_path):
    """Two colour images of 8 x 6 pixels, no depth."""
    for i in range(2):
        Image.fromarray(np.full((6, 8, 3), i, np.uint8)).save(tmp_path / f"{i}.png")
    return tmp_path


def read(path: Path, **given: float):
    """As a verb reads it that was given these options."""
    found = []

    @verb
    def look(*, reading: PicturesReading = PicturesReading()) -> None:
        found.append(read_pictures(path, reading))

    look(**{f"reading__{name}": value for name, value in given.items()})
    return found[0]


def test_a_lens_that_nobody_knows_may_be_told(pictures, capsys):
    assert read(pictures, focal=11.0).camera.fx == 11.0
    assert "no depth images" in capsys.readouterr().err


def test_a_lens_that_the_take_knows_may_not(pictures):
    intrinsics = '{"width": 8, "height": 6, "intrinsic_matrix": [10, 0, 0, 0, 10, 0, 3.5, 2.5, 1]}'
    (pictures / "camera_intrinsic.json").write_text(intrinsics)
    with pytest.raises(BadInput, match="--focal does nothing for a take that knows its camera"):
        read(pictures, focal=11.0)


def test_a_scale_of_depth_needs_depth(pictures):
    with pytest.raises(BadInput, match="--depth-scale does nothing for a take that is no folder with depth"):
        read(pictures, depth_scale=5000.0)
