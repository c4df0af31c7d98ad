"""A held expression to one map."""

from dataclasses import replace

import numpy as np
import pytest

from blendshape_stage import TrueLandmarks, actor, capture
from mien.blendshapes.scan.pipeline import FusionConfig, scan_take
from mien.errors import BadInput
from mien.landmarks.detector import Landmarks2D
from mien.mesh import ClosestPoint
from mien.register.correspond import Rejection
from mien.register.rigid_icp import IcpConfig, icp

CONFIG = FusionConfig(pixel_mm=1.0)


def error(map_, mesh) -> float:
    """Mean distance of the front of a map from the truth, best rigid place, mm."""
    points = map_.positions[map_.known & (map_.confidence > 0.05)].astype(float)
    points = points[(points[:, 2] > 50) & (np.abs(points[:, 1] + 20) < 75)]
    tree = ClosestPoint(mesh)
    settings = IcpConfig(robust="tukey", max_points=2000, rejection=Rejection(max_distance=8))
    return float(tree.query(icp(points, tree, config=settings).transform.apply(points)).distances.mean())


@pytest.fixture(scope="module")
def fused():
    take, landmarker, _ = capture("neutral")
    return scan_take(take, CONFIG, landmarker)


def test_many_frames_are_nearer_to_the_truth_than_one(fused):
    take, landmarker, _ = capture("neutral")
    alone = replace(take, count=1, frames=lambda: iter([next(iter(take))]))
    single = scan_take(alone, CONFIG, landmarker)
    many, one = (error(found.map, actor().neutral) for found in (fused, single))
    assert many < 0.39
    assert many < 0.75 * one
    assert fused.used == 7
    assert fused.dropped == 0


def test_colour_is_the_skins(fused):
    middle = fused.map.colors[np.isfinite(fused.map.colors[..., 0]) & (fused.map.positions[..., 2] > 90)]
    assert (middle[:, 0] > middle[:, 2]).mean() > 0.8


def test_a_face_that_does_not_hold_still_is_refused():
    take, landmarker, _ = capture("neutral")
    lower = np.arange(478) % 2 == 0

    class Talking(TrueLandmarks):
        def detect(self, image, time=None):
            found = super().detect(image, time)
            return Landmarks2D(found.points + lower[:, None] * [0, 40 * (time % 0.7)], found.depth, {})

    with pytest.raises(BadInput, match="hold one expression"):
        scan_take(take, CONFIG, Talking(landmarker.pixels))
