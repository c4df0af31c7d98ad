"""`mien.show` gives a picture of every noun, and of what a result holds."""

import io
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import mien
from mien.pictures.notebook import Picture, as_image


@pytest.fixture(scope="module")
def rig():
    return mien.load_face().rig


def test_nouns_have_pictures(rig, tmp_path):
    few = mien.Performance(rig, np.zeros((3, len(rig.names))), mien.Transform.identity(3), 30.0, np.ones(3, bool))
    image = np.full((4, 6, 3), 7, np.uint8)
    shown = {
        "mesh": mien.show(rig.neutral),
        "scan": mien.show(mien.Scan(rig.neutral)),
        "performance": mien.show(few),
        "result": mien.show(SimpleNamespace(performance=None, rig=None, mesh=rig.neutral)),
        "frame": mien.show(mien.RGBDFrame(image, None, 0.0)),
    }
    assert all(isinstance(picture, Picture) for picture in shown.values())
    np.testing.assert_array_equal(shown["mesh"].image, shown["scan"].image)
    np.testing.assert_array_equal(shown["frame"].image, image)
    assert shown["performance"].image.std() > 5
    with Image.open(io.BytesIO(shown["mesh"]._repr_png_())) as png:
        assert png.size == shown["mesh"].image.shape[1::-1]
    shown["mesh"].save(tmp_path / "a.png")
    assert (tmp_path / "a.png").is_file()
    assert mien.show(shown["mesh"]) is shown["mesh"]


def test_a_rig_s_shapes_are_a_sheet(rig):
    assert mien.show(rig.with_shapes(rig.neutral, rig.deltas)).image.shape[1] > 3 * 240


def test_markers_are_dots_where_they_are():
    square = np.array([[[0.0, 0, 0], [100, 0, 0], [0, 50, 0], [100, 50, 0]]])
    image = mien.show(mien.Markers(square, tuple("abcd"), 60.0)).image
    assert ((image[..., 0] < 255).sum()) == 4 * 7 * 7
    gone = mien.Markers(np.full((1, 1, 3), np.nan), ("a",), 60.0)
    assert (mien.show(gone).image == 255).all()


def test_numbers_become_colours_and_nothing_is_grey():
    colours = as_image(np.array([[1.0, 2.0, 0.0, np.nan]]))
    assert colours.shape == (1, 4, 3)
    np.testing.assert_array_equal(colours[0, 2], colours[0, 3])
    assert (colours[0, 0] != colours[0, 1]).any()
    np.testing.assert_array_equal(as_image(np.ones((1, 1, 3))), np.full((1, 1, 3), 255))


@pytest.mark.parametrize("thing", [np.zeros(3), 7, "face.glb"])
def test_what_has_no_picture(thing):
    with pytest.raises(TypeError, match="show: "):
        mien.show(thing)
