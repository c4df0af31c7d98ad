from dataclasses import replace

import numpy as np
import pytest

import light_scene
from mien.errors import BadInput
from mien.experiments.light_stage import LightStageConfig, score_capture, staged_capture
from mien.light.decode_sinusoids import DecodeConfig
from mien.light.motion import MotionConfig
from mien.light.patterns import gray_set, phase_set
from mien.light.pipeline import LightConfig, decode_capture, within_light
from mien.light.triangulate import DepthMap
from mien.stage import STRANGER, SkinConfig, make_performer, make_skin

SMALL = LightStageConfig(size=(216, 288), projector=(512, 384))
COARSE = LightConfig(decode=DecodeConfig(border_px=1, window_px=6.0))


def skin(seed, config=None):
    return make_skin(
        make_performer(seed, config) if config else make_performer(seed),
        SkinConfig(levels=1, eyes_and_teeth=False),
        seed,
    )


@pytest.fixture(scope="module")
def actor():
    return skin(3)


@pytest.fixture(scope="module")
def still(actor):
    smile = expression(actor, 0.5)
    return staged_capture(actor, smile, smile, SMALL)


def expression(actor, amount):
    weights = np.zeros(len(actor.names))
    for name in ("mouthSmileLeft", "mouthSmileRight", "browInnerUp"):
        weights[actor.names.index(name)] = amount
    return weights


def test_a_still_face_is_measured_better_by_both_than_by_either(still):
    score = score_capture(still, COARSE)
    assert score.fused_mm < 0.95 * score.geometry_mm
    assert score.fused_mm < 0.15
    assert score.fused_deg < 0.75 * score.geometry_deg
    assert score.share > 0.6


def test_a_person_of_another_kind_is_measured_alike():
    other = skin(501, STRANGER)
    smile = expression(other, 0.4)
    capture = staged_capture(other, smile, smile, SMALL)
    assert score_capture(capture, COARSE).fused_mm < 0.4


def test_motion_taken_out_halves_the_normals_error(actor):
    moving = staged_capture(actor, expression(actor, 0.4), expression(actor, 0.5), SMALL, move_mm=(6.0, 3.0, 2.0))
    left = replace(COARSE, motion=MotionConfig(compensate=False), decode=replace(COARSE.decode, motion=False))
    scores = [score_capture(moving, config) for config in (COARSE, left)]
    assert scores[0].light_deg < 0.6 * scores[1].light_deg
    assert scores[0].fused_mm < 0.7 * scores[1].fused_mm


@pytest.mark.parametrize("patterns", [phase_set(512, 384, 4, 24.0), gray_set(512, 384)], ids=["phase", "gray"])
def test_other_patterns_and_one_camera_with_a_projector(actor, patterns):
    smile = expression(actor, 0.5)
    capture = staged_capture(actor, smile, smile, SMALL, patterns)
    for images in (capture.images, {"left": capture.images["left"]}):
        score = score_capture(replace(capture, images=images), COARSE)
        assert score.geometry_mm < 2.0
        assert score.share > 0.5


def test_pictures_of_another_rig_are_told(still):
    swapped = {"left": still.images["right"], "right": still.images["left"]}
    with pytest.raises(BadInput, match="swapped"):
        decode_capture(swapped, still.patterns, still.rig, COARSE)
    with pytest.raises(BadInput, match="another camera or mode"):
        decode_capture({"left": still.images["left"][:, :100]}, still.patterns, still.rig, COARSE)
    with pytest.raises(BadInput, match="11 pictures"):
        decode_capture({"left": still.images["left"][:11]}, still.patterns, still.rig, COARSE)
    with pytest.raises(BadInput, match="any camera"):
        decode_capture({"top": still.images["left"]}, still.patterns, still.rig, COARSE)
    with pytest.raises(BadInput, match="calibrated projector"):
        decode_capture({"left": still.images["left"]}, still.patterns, replace(still.rig, projector=None), COARSE)


def test_each_fault_of_a_whole_capture_is_one_clear_line(still):
    order = np.arange(len(still.patterns))
    order[[8, 9]] = 9, 8
    left, right = still.rig.cameras
    other = replace(right, camera=replace(right.camera, fx=1.3 * right.camera.fx, fy=1.3 * right.camera.fy))
    for images, rig, line in (
        (
            {name: seen ** (1 / 2.2) for name, seen in still.images.items()},
            still.rig,
            "right|left: the camera looks gamma",
        ),
        ({name: np.roll(seen, 1, axis=0) for name, seen in still.images.items()}, still.rig, "another order"),
        ({name: seen[order] for name, seen in still.images.items()}, still.rig, "the lamps' conditions"),
        (still.images, replace(still.rig, cameras=(left, other)), "swapped, or"),
    ):
        with pytest.raises(BadInput, match=line):
            decode_capture(images, still.patterns, rig, COARSE)


def test_points_off_the_projectors_planes_are_left_out_and_where_most_are_it_is_another_rigs():
    rig = light_scene.rig()
    left = rig.cameras[0]
    seen = light_scene.ball_columns(left, rig.projector)
    truth, _ = light_scene.ball_depth(left)
    stray = truth.copy()
    stray[100:104, 80:90] += 12.0
    kept = within_light(DepthMap(stray, np.ones_like(truth)), left, rig.projector, seen)
    np.testing.assert_array_equal(np.isfinite(kept.z), np.isfinite(truth) & (stray == truth))
    with pytest.raises(BadInput, match="projector pixels off the patterns"):
        within_light(DepthMap(truth * 1.4, np.ones_like(truth)), left, rig.projector, seen)
