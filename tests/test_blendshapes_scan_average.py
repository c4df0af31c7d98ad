"""The average of the frames."""

import numpy as np
import pytest

from blendshape_stage import capture
from mien.blendshapes.cylinder_map import CylinderLayout
from mien.blendshapes.scan.average import fused, place_in_head, registered, starts_of, surface_map
from mien.blendshapes.scan.frames import FramesConfig, PlacedFrame, frames_with_face, reference_frame
from mien.blendshapes.scan.fuse import FuseConfig

LAYOUT = CylinderLayout(2.0)


@pytest.fixture(scope="module")
def seen():
    take, landmarker, _ = capture("neutral")
    return frames_with_face(take, landmarker)


def test_frames_are_laid_on_the_average_and_widen_it(seen):
    camera = capture("neutral")[0].camera
    reference, T = reference_frame(seen, "neutral")
    first = fused([PlacedFrame(seen[reference], T)], camera, LAYOUT, FuseConfig())
    starts, moved = place_in_head(seen, reference, T, "neutral", FramesConfig())
    placed, at = registered(seen, starts, first, LAYOUT, camera, FramesConfig(), reference)
    whole = fused(placed, camera, LAYOUT, FuseConfig())
    assert placed[at].seen is seen[reference]
    assert moved < 3
    assert surface_map(whole, LAYOUT).known.sum() > 1.1 * surface_map(first, LAYOUT).known.sum()
    again = starts_of(placed[:2], seen, starts)
    assert again[-1] is starts[-1]


def test_each_frame_starts_where_its_landmarks_place_it(seen):
    reference, T = reference_frame(seen, "neutral")
    starts, _ = place_in_head(seen, reference, T, "neutral", FramesConfig())
    goal = T.apply(seen[reference].landmarks)
    for one, start in zip(seen, starts, strict=True):
        assert np.nanmedian(np.linalg.norm(start.apply(one.landmarks) - goal, axis=1)) < 3
    turned = [np.linalg.norm(start.rotation - T.rotation) for start in starts]
    assert max(turned) > 0.05
