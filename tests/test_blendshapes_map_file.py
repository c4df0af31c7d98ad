"""Maps on disk."""

import numpy as np
import pytest

from mien.blendshapes.cylinder_map import CylinderLayout, CylinderMap, map_of_scan
from mien.blendshapes.map_file import read_map, write_map
from mien.errors import BadInput
from mien.faces import load_face
from mien.io.exr import write_exr
from mien.mesh import Scan


@pytest.fixture(scope="module")
def face_map() -> CylinderMap:
    return map_of_scan(Scan(load_face().rig.neutral), CylinderLayout(2.0))


def test_a_map_comes_back_as_it_was_written(tmp_path, face_map):
    write_map(tmp_path / "smile.exr", face_map)
    again = read_map(tmp_path / "smile.exr")
    assert again.name == "smile"
    assert again.layout.shape == face_map.layout.shape
    np.testing.assert_array_equal(again.positions, face_map.positions)
    np.testing.assert_array_equal(again.colors, face_map.colors)
    np.testing.assert_array_equal(again.confidence, face_map.confidence)


def test_other_images_are_refused_by_what_they_lack(tmp_path, face_map):
    small = np.zeros((4, 5), np.float32)
    write_exr(tmp_path / "depth.exr", {"Z": small})
    with pytest.raises(BadInput, match="no channel X, Y, R, G, B, confidence"):
        read_map(tmp_path / "depth.exr")
    write_exr(tmp_path / "size.exr", dict.fromkeys(("X", "Y", "Z", "R", "G", "B", "confidence"), small))
    with pytest.raises(BadInput, match="5 x 4 pixels"):
        read_map(tmp_path / "size.exr")
    turned = CylinderMap(face_map.layout, face_map.positions[:, ::-1].copy(), face_map.colors, face_map.confidence)
    write_map(tmp_path / "turned.exr", turned)
    with pytest.raises(BadInput, match="not laid out on our cylinder"):
        read_map(tmp_path / "turned.exr")
