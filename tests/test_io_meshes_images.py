"""Pictures that go with meshes."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.meshes.images import read_image, write_image

IMAGE = np.random.default_rng(0).integers(0, 256, (5, 7, 3), dtype=np.uint8)


def test_a_png_comes_back_to_the_bit(tmp_path):
    write_image(tmp_path / "a.png", IMAGE)
    np.testing.assert_array_equal(read_image(tmp_path / "a.png"), IMAGE)


def test_what_is_no_picture_is_named(tmp_path):
    write_image(tmp_path / "a.png", IMAGE)
    whole = (tmp_path / "a.png").read_bytes()
    for content in (b"", b"no picture", whole[: len(whole) // 2]):
        (tmp_path / "a.png").write_bytes(content)
        with pytest.raises(BadInput, match=r"a\.png: is no picture that can be read"):
            read_image(tmp_path / "a.png")
    with pytest.raises(BadInput, match="no such file"):
        read_image(tmp_path / "b.png")
