import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.exr import read_exr, write_exr


def channels():
    rng = np.random.default_rng(1)
    images = {name: rng.normal(size=(5, 7)).astype(np.float32) for name in ("X", "Y", "confidence", "a0.u")}
    images["X"][2, 3] = np.nan
    return images


def test_round_trip_keeps_names_values_and_gaps(tmp_path):
    write_exr(tmp_path / "a.exr", channels())
    back = read_exr(tmp_path / "a.exr")
    assert set(back) == set(channels())
    for name, image in channels().items():
        np.testing.assert_array_equal(back[name], image)


def test_half_keeps_sixteen_bits(tmp_path):
    write_exr(tmp_path / "a.exr", channels(), half=True)
    back = read_exr(tmp_path / "a.exr")
    np.testing.assert_array_equal(back["Y"], channels()["Y"].astype(np.float16).astype(np.float32))


@pytest.mark.parametrize("cut", [0, 3, 8, 60, -20])
def test_a_broken_file_is_one_line(tmp_path, cut):
    write_exr(tmp_path / "a.exr", channels())
    data = (tmp_path / "a.exr").read_bytes()
    (tmp_path / "b.exr").write_bytes(data[:cut])
    with pytest.raises(BadInput, match=r"b\.exr: .*OpenEXR"):
        read_exr(tmp_path / "b.exr")


def test_channels_of_several_sizes_are_refused(tmp_path):
    with pytest.raises(BadInput, match="one size"):
        write_exr(tmp_path / "a.exr", {"a": np.zeros((2, 2), np.float32), "b": np.zeros((3, 2), np.float32)})
    assert not list(tmp_path.iterdir())
