import numpy as np
import pytest

import light_scene
from mien.errors import BadInput
from mien.light.cut_out import MARGIN_PX, Box, cut_view, lit_cutout
from mien.light.patterns import paper_set

PATTERNS = paper_set(256, 192)


def test_the_cut_out_holds_all_that_is_lit_and_its_camera_sees_it_alike():
    view = light_scene.rig().cameras[0]
    images = np.zeros((len(PATTERNS), 200, 160))
    images[:, 80:120, 60:90] = 0.5
    cut = lit_cutout(images, view, PATTERNS)
    assert cut.box == Box(80 - MARGIN_PX, 60 - MARGIN_PX, 120 + MARGIN_PX, 90 + MARGIN_PX)
    assert cut.images.sum() == images.sum()
    assert (cut.view.camera.height, cut.view.camera.width) == cut.images.shape[1:]
    point = np.array([[5.0, -3.0, 600.0]])
    shifted = cut.view.camera.project(point) + np.array([cut.box.left, cut.box.top])
    np.testing.assert_allclose(shifted, view.camera.project(point))
    assert cut_view(view, Box(0, 0, 200, 160)).camera == view.camera


def test_nothing_lit_is_told():
    with pytest.raises(BadInput, match="left: the full-on pattern lights nothing"):
        lit_cutout(np.zeros((len(PATTERNS), 200, 160)), light_scene.rig().cameras[0], PATTERNS)
