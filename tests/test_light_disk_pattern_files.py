import numpy as np
import pytest
from PIL import Image

from mien.errors import BadInput
from mien.light.disk.light_take import read_grey
from mien.light.disk.pattern_files import pattern_set, write_pattern_pictures
from mien.light.patterns import read_patterns


def test_pictures_undo_to_the_patterns_and_lamps_have_none(tmp_path):
    patterns = pattern_set("paper", "64x48")
    assert write_pattern_pictures(tmp_path / "p", patterns) == 7
    assert read_patterns(tmp_path / "p" / "patterns.json") == patterns
    shown = read_grey(tmp_path / "p" / "pattern_05.png", 2.2)
    np.testing.assert_allclose(shown, patterns.image(5), atol=0.01)
    write_pattern_pictures(tmp_path / "q", patterns, linear=True)
    with Image.open(tmp_path / "q" / "pattern_00.png") as picture:
        assert picture.size == (64, 48)


@pytest.mark.parametrize("size", ["64", "64x", "axb", "8x8", "64x48x3"])
def test_odd_sizes_and_sets_are_told(size):
    with pytest.raises(BadInput, match="width x height"):
        pattern_set("gray", size)
    with pytest.raises(BadInput, match="one of paper"):
        pattern_set("moire", "64x48")
