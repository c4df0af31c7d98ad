import numpy as np
import pytest

from mien.experiments.light_stage import (
    LightStageConfig,
    band_errors,
    looking_at,
    score_scan,
    staged_capture,
    staged_rig,
)
from mien.light.disk.light_scan import LightScan
from mien.light.patterns import gray_set
from mien.light.pipeline import LightConfig, light_sources
from mien.stage import SkinConfig, make_performer, make_skin
from mien.stage.sensors.active_light import Placed, look

SMALL = LightStageConfig(size=(108, 144), projector=(256, 192))


@pytest.fixture(scope="module")
def skin():
    return make_skin(make_performer(5), SkinConfig(levels=1, eyes_and_teeth=False), 5)


def test_everything_looks_at_the_face():
    centre = np.array([3.0, -10.0, 60.0])
    rig, T_rig_face = staged_rig(centre, SMALL)
    for view in (*rig.cameras, rig.projector):
        seen = (view.T_view_rig @ T_rig_face).apply(centre[None])
        np.testing.assert_allclose(view.camera.project(seen)[0], [view.camera.cx, view.camera.cy], atol=1e-6)
    above = looking_at(np.array([0.0, 100.0, 100.0]), np.zeros(3))
    assert above.apply(np.array([[0.0, 1.0, 0.0]]))[0, 1] < above.apply(np.zeros((1, 3)))[0, 1]


def test_a_face_moves_evenly_between_its_slots(skin):
    rest, smile = np.zeros(len(skin.names)), np.zeros(len(skin.names))
    smile[skin.names.index("mouthSmileLeft")] = 1.0
    capture = staged_capture(skin, rest, smile, SMALL, gray_set(256, 192), (0.0, 0.0, 5.0))
    half = (capture.truth(0).vertices + capture.truth(len(capture.patterns) - 1).vertices) / 2
    np.testing.assert_allclose(capture.truth((len(capture.patterns) - 1) / 2).vertices, half)


def test_the_truth_itself_scores_nothing(skin):
    rest = np.zeros(len(skin.names))
    capture = staged_capture(skin, rest, rest, SMALL, gray_set(256, 192))
    sources = light_sources(capture.images, capture.patterns, capture.rig)
    view = sources.view
    seen = look(capture.truth(0), Placed(view.camera, view.T_view_rig))
    points, normals = np.full((2, *seen.mask.shape, 3), np.nan)
    points[seen.mask], normals[seen.mask] = seen.points, seen.normals
    whole = np.ones(seen.mask.shape)
    score = score_scan(LightScan(points, normals, whole, whole, whole), sources, capture, LightConfig())
    assert score.fused_mm == 0
    assert score.fused_deg < 1e-5
    assert score.geometry_mm > 0
    assert score.bands["fused"] == (0.0, 0.0, 0.0, 0.0)


def test_an_error_falls_into_the_band_of_its_breadth():
    known = np.ones((120, 160), bool)
    x = np.arange(160)[None] * np.ones((120, 1))
    fine, middle, broad = (band_errors(np.sin(x / length), known, 0.5) for length in (0.5, 6.0, 1e6))
    assert np.argmax(fine) == 0
    assert np.argmax(middle) == 2
    assert np.argmax(band_errors(np.ones((120, 160)), known, 0.5)) == 3
    assert max(broad) < 1e-3
