import numpy as np
import pytest

from mien.viewer.scene_file import ALIGN, KINDS, SceneWriter, read_array, read_scene


@pytest.mark.parametrize("kind", KINDS)
def test_arrays_come_back_and_lie_aligned(kind):
    scene, values = SceneWriter(), np.arange(7).reshape(7, 1).astype(KINDS[kind])
    first, second = scene.array(values[:3], kind), scene.array(values, kind)
    header, body = read_scene(scene.file({"a": first, "b": second}))
    np.testing.assert_array_equal(read_array(body, header["b"]), values)
    assert header["b"]["at"] % ALIGN == 0
    assert (len(scene.file(header)) - len(body)) % ALIGN == 0


def test_pictures_are_png_where_small_and_jpeg_where_large():
    scene = SceneWriter()
    assert scene.picture(np.zeros((8, 8, 3), np.uint8))["mime"] == "image/png"
    large = scene.picture(np.zeros((600, 600, 3), np.uint8))
    assert large["mime"] == "image/jpeg"
    assert large["bytes"] < 600 * 600
