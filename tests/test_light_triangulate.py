from dataclasses import replace

import numpy as np
import pytest

import light_scene
from mien.errors import BadInput
from mien.light.decode_sinusoids import Decoded
from mien.light.triangulate import (
    DepthMap,
    TriangulateConfig,
    cleaned,
    facing,
    pieces,
    pixel_rays,
    rectify,
    triangulate_pair,
    triangulate_projector,
)

RIG = light_scene.rig()
LEFT, RIGHT = RIG.cameras


def test_a_point_lies_on_one_row_of_a_rectified_pair():
    pair = rectify(LEFT, RIGHT)
    points = np.random.default_rng(0).normal(size=(20, 3)) * 50 + light_scene.CENTRE
    rows = []
    for view, camera, R in ((LEFT, pair.left, pair.R_rect_left), (RIGHT, pair.right, pair.R_rect_right)):
        rows.append(camera.project(view.T_view_rig.apply(points) @ R.T)[:, 1])
    np.testing.assert_allclose(rows[0], rows[1], atol=1e-9)
    assert pair.baseline_mm == pytest.approx(160)


def test_two_cameras_find_a_ball():
    seen = [light_scene.ball_columns(view, RIG.projector) for view in (LEFT, RIGHT)]
    depth = triangulate_pair(LEFT, RIGHT, *seen)
    truth, _ = light_scene.ball_depth(LEFT)
    known = np.isfinite(depth.z)
    assert known.sum() > 0.6 * np.isfinite(truth).sum()
    assert np.abs(depth.z - truth)[known].mean() < 0.1
    assert np.nanmedian(depth.sigma_mm) < 1.0


@pytest.mark.parametrize("distortion", [(0.0,) * 5, (-0.1, 0.05, 0.001, 0.002, 0.0)])
def test_a_camera_and_a_projector_find_a_ball_through_its_lens(distortion):
    projector = replace(RIG.projector, distortion=distortion)
    depth = triangulate_projector(LEFT, projector, light_scene.ball_columns(LEFT, projector))
    truth, _ = light_scene.ball_depth(LEFT)
    known = np.isfinite(depth.z)
    assert known.sum() > 0.7 * np.isfinite(truth).sum()
    assert np.abs(depth.z - truth)[known].max() < 0.02


def test_a_projector_above_the_camera_needs_its_rows():
    above = light_scene.view("above", 0.0, -150.0, 500.0, (256, 256))
    projector = replace(above, distortion=(-0.1, 0.05, 0.001, 0.002, 0.0))
    rays, (truth, _) = pixel_rays(LEFT.camera), light_scene.ball_depth(LEFT)
    local = (projector.T_view_rig @ LEFT.T_view_rig.inverse()).apply((rays * truth[..., None]).reshape(-1, 3))
    pixels = projector.distorted(projector.camera.project(local)).reshape(*truth.shape, 2)
    pixels += 0.05 * np.random.default_rng(0).normal(size=pixels.shape)
    columns, rows = (Decoded(pixels[..., axis], np.where(np.isfinite(truth), 0.05, np.nan)) for axis in (0, 1))
    depth = triangulate_projector(LEFT, projector, columns, rows=rows)
    known = np.isfinite(depth.z)
    assert known.sum() > 0.7 * np.isfinite(truth).sum()
    assert np.abs(depth.z - truth)[known].mean() < 0.3
    assert 0.5 < np.sqrt((((depth.z - truth) / depth.sigma_mm)[known] ** 2).mean()) < 2
    with pytest.raises(BadInput, match="mm away, none of them within"):
        triangulate_projector(LEFT, projector, columns, TriangulateConfig(farthest_mm=300.0), rows)


def test_no_match_and_one_camera_twice_are_told():
    with pytest.raises(BadInput, match="one camera"):
        rectify(LEFT, replace(LEFT, name="other"))
    nothing = Decoded(np.full((200, 160), np.nan), np.full((200, 160), np.nan))
    with pytest.raises(BadInput, match="find their column"):
        triangulate_pair(LEFT, RIGHT, nothing, nothing)


def test_crumbs_and_grazing_surface_are_left_out():
    z = np.full((60, 80), 500.0)
    z[:, 40:] = 520.0
    z[10, 60:64] = 900.0
    sizes = pieces(z, 4.0)
    assert sizes[10, 61] == 0
    assert sizes[30, 10] > 2000
    camera = LEFT.camera.scaled(0.5)
    slope = 500.0 + 30 * np.arange(camera.width)[None] * np.ones((camera.height, 1))
    assert np.median(facing(slope, camera)) < 0.2
    assert np.median(facing(np.full_like(slope, 500.0), camera)) > 0.95


def test_points_lie_on_their_pixels_rays():
    depth = DepthMap(np.full((200, 160), 700.0), np.zeros((200, 160)))
    points = depth.points(LEFT.camera)
    np.testing.assert_allclose(LEFT.camera.project(points)[5, 7], [7, 5])
    assert pixel_rays(LEFT.camera)[..., 2].min() == 1
    assert TriangulateConfig().nearest_mm < 700


def test_crumbs_and_what_is_too_near_or_far_are_left_out():
    z = np.full((LEFT.camera.height, LEFT.camera.width), np.nan)
    z[20:120, 20:120] = 600.0
    z[130:135, 140:145] = 600.0
    z[150:190, 20:60] = 100.0
    z[150:190, 80:120] = 5000.0
    found = cleaned(DepthMap(z, np.ones_like(z)), LEFT.camera, TriangulateConfig())
    expected = np.zeros(z.shape, bool)
    expected[20:120, 20:120] = True
    np.testing.assert_array_equal(np.isfinite(found.z), expected)
    np.testing.assert_array_equal(np.isfinite(found.sigma_mm), expected)
