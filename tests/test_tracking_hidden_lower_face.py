"""The lower face alone: what is fitted of it, and its performance on the whole rig."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.landmarks.on_rig import BROWS, OUTER_LIPS
from mien.rgbd import RgbdTake
from mien.tracking.hidden.lower_face import lower_face_model, upper_shapes
from mien.tracking.pipeline import TrackTakeConfig, track_take

FRAMES = 20


def masked(rig, weights, T, time):
    """Depth below the nose's tip alone."""
    frame = stage.sensed(rig, weights, T, time, noise=0.3, seed=round(time * 100))
    assert frame.depth is not None
    tip = stage.CAMERA.project(T.apply(stage.landmarks().attachment.points(rig.mesh(weights))[4:5]))[0, 1]
    depth = frame.depth.copy()
    depth[: int(tip)] = 0.0
    return replace(frame, depth=depth)


def test_the_model_ends_at_the_nose():
    rig = stage.person()
    model = lower_face_model(rig, stage.landmarks())
    points = stage.landmarks().attachment.points(rig.neutral)
    assert model.share[model.neutral[:, 1] > points[4, 1]].sum() < 0.15, "of nostrils, which the lower face encloses"
    assert not any(name.startswith(("brow", "eye", "cheekSquint")) for name in model.rig.names)
    assert model.landmarks.known[list(OUTER_LIPS)].all()
    assert not model.landmarks.known[list(BROWS)].any()
    assert upper_shapes(rig.names).sum() == len(rig.names) - len(model.rig.names) == 21


@pytest.fixture(scope="module")
def tracked():
    """Jaw and smile behind a mask, brows up that nobody sees, no landmarks but of the mask's own making."""
    rig, poses = stage.person(), stage.sway(FRAMES)
    weights = stage.talk(rig, FRAMES)
    weights[:, rig.index("browInnerUp")] = 1.0
    frames = [masked(rig, w, T, t / 30.0) for t, (w, T) in enumerate(zip(weights, poses, strict=True))]
    take = RgbdTake("masked", stage.CAMERA, 30.0, FRAMES, True, lambda: iter(frames))
    blind = stage.Told({round(frame.time, 4): None for frame in frames})
    found = track_take(take, rig, stage.landmarks(), blind, TrackTakeConfig(hidden="upper"))
    return rig, weights, poses, found


def test_the_lower_face_is_found_and_tracked_by_depth_alone(tracked):
    rig, weights, poses, found = tracked
    assert found.performance.tracked.all()
    played = found.performance.weights[:, [rig.index("jawOpen"), rig.index("mouthSmileLeft")]]
    true = weights[:, [rig.index("jawOpen"), rig.index("mouthSmileLeft")]]
    assert np.abs(played - true).mean() < 0.6 * true.mean()
    flip = np.array([1.0, -1.0, -1.0])
    off = np.linalg.norm(found.performance.T_world_face.translation * flip - [T.translation for T in poses], axis=1)
    assert off.max() < 4.0


def test_the_whole_rig_comes_back_with_its_upper_shapes_at_rest(tracked):
    rig, _, _, found = tracked
    assert found.performance.rig.names[: len(rig.names)] == rig.names
    upper = np.flatnonzero(upper_shapes(rig.names))
    np.testing.assert_array_equal(found.performance.weights[:, upper], 0.0)
