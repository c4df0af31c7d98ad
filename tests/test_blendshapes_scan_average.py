"""The average of the frames."""

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
