"""RGB-D takes made by hand."""

import numpy as np
import pytest

from mien.camera import Camera
from mien.depth import RGBDFrame
from mien.rgbd import RgbdTake

CAMERA = Camera(60.0, 61.0, 23.5, 15.5, 48, 32)


def made(count=4, rate=20.0):
    """A take in memory: smooth colour that a video codec keeps, depth with holes."""
    y, x = np.mgrid[:32, :48]

    def frames():
        for i in range(count):
            color = np.stack([5 * x, 7 * y, np.full_like(x, 20 * i)], -1).astype(np.uint8)
            depth = (600 + 3 * x + y + i).astype(np.float32)
            depth[:4] = 0
            yield RGBDFrame(color, depth, i / rate)

    return RgbdTake("made", CAMERA, rate, count, True, frames)


def same(found, expected, tolerance=0.0):
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_array_equal(a.color, b.color)
        np.testing.assert_allclose(a.depth, b.depth, atol=tolerance)
        assert a.time == pytest.approx(b.time, abs=1e-6)
