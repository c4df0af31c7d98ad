import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.exr import write_exr
from mien.light.cut_out import Box
from mien.light.disk.light_scan import LightScan, read_light_scan, write_light_scan


def made():
    y, x = np.mgrid[:6, :8].astype(float)
    points = np.stack([x, y, 500 + 0.1 * x], -1)
    points[:, 5:, 2] += 40
    points[0, 0] = np.nan
    normals = np.broadcast_to([0.0, 0.0, -1.0], points.shape) + 0 * points
    return LightScan(points, normals, 0.3 + 0 * x, 1 + 0 * x, 0.1 + 0 * x)


def test_a_scan_comes_back_from_its_file(tmp_path):
    scan = made()
    write_light_scan(tmp_path / "s.exr", scan)
    back = read_light_scan(tmp_path / "s.exr")
    for field in ("points", "normals", "albedo", "confidence", "sigma_mm"):
        np.testing.assert_allclose(getattr(back, field), getattr(scan, field), rtol=1e-6)
    assert repr(back) == "LightScan(47 points, about 500 mm away)"
    write_exr(tmp_path / "o.exr", {"Y": np.ones((2, 2), np.float32)})
    with pytest.raises(BadInput, match="channels"):
        read_light_scan(tmp_path / "o.exr")


def test_triangles_join_neighbours_face_the_camera_and_stop_at_steps():
    mesh = made().mesh(3.0)
    assert len(mesh.vertices) == 47
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normals[:, 2] < 0).all()
    assert len(mesh.faces) == 2 * (5 * 4 + 5 * 2) - 1


def test_a_cut_out_is_laid_out_in_the_whole_picture():
    whole = made().in_whole_picture(Box(2, 3, 8, 11), (10, 20))
    assert whole.points.shape == (10, 20, 3)
    np.testing.assert_array_equal(whole.points[2:8, 3:11], made().points)
    assert whole.known.sum() == made().known.sum()
    assert whole.confidence[0, 0] == 0
