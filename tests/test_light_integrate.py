import numpy as np
import pytest

import light_scene
from mien.errors import BadInput
from mien.light.integrate import integrate, log_slopes, on_edges
from mien.light.triangulate import pixel_rays

LEFT = light_scene.rig().cameras[0]


def test_a_balls_normals_give_the_ball_back():
    truth, normals = light_scene.ball_depth(LEFT)
    rays = pixel_rays(LEFT.camera)
    with np.errstate(invalid="ignore"):
        mask = np.abs((normals * rays).sum(-1)) / np.linalg.norm(rays, axis=-1) > 0.3
    found = integrate(normals, LEFT.camera, rays, mask, float(np.nanmean(truth[mask])))
    off = (found - truth)[mask]
    assert np.abs(off - off.mean()).mean() < 0.3


def test_slopes_are_those_of_the_logarithm_of_depth():
    truth, normals = light_scene.ball_depth(LEFT)
    slopes = log_slopes(normals, LEFT.camera, pixel_rays(LEFT.camera))
    (across, down), _ = on_edges(slopes, np.ones(truth.shape))
    middle = np.s_[80:120, 60:100]
    np.testing.assert_allclose(across[middle], np.diff(np.log(truth), axis=1)[middle], atol=2e-5)
    np.testing.assert_allclose(down[middle], np.diff(np.log(truth), axis=0)[middle], atol=2e-5)


def test_nothing_to_go_by_is_told():
    with pytest.raises(BadInput, match="no normal"):
        integrate(np.full((4, 4, 3), np.nan), LEFT.camera, np.ones((4, 4, 3)), np.ones((4, 4), bool), 500.0)
