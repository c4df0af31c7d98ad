"""Selected frames seen from the head: the neutral one first, denoised, frames that are not there left out."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.mesh import Scan
from mien.scans.fitted_scan import FittedScan
from mien.scans.take_in_head import denoise_frames, take_in_head
from mien.takes.preprocess import preprocess_take
from scan_stage import FRAMES, scan_stage


def test_a_quiet_parabola_passes_unchanged_and_noise_falls():
    t = np.arange(60) / 60.0
    path = np.stack([3 * t, 5 * t**2, 1 - t], 1)[:, None].repeat(4, axis=1) + np.arange(4)[:, None]
    frames = [0, 30, 41]
    np.testing.assert_allclose(denoise_frames(path, frames, 60.0)[1:], path[frames[1:]], atol=1e-9)
    noisy = path + np.random.default_rng(0).normal(size=path.shape) * 0.1
    left = np.abs(denoise_frames(noisy, frames, 60.0)[1:] - path[frames[1:]]).mean()
    assert left < 0.8 * np.abs(noisy - path).mean()


def seen(name: str, frame: int) -> FittedScan:
    scan = scan_stage()[3][0].scan
    return FittedScan(Scan(scan.mesh, name=name), frame, scan.mesh, None)


def test_the_calmest_scan_comes_first_and_frames_outside_the_take_are_left_out():
    ready = preprocess_take(scan_stage()[1].markers)
    open_jaw, far, rest, smile = (seen(f"s_{f}", f) for f in (70, 9999, 10, 110))
    found = take_in_head(ready, [open_jaw, far, rest, smile])
    assert [scan.name for scan in found.scans] == ["s_10", "s_70", "s_110"]
    np.testing.assert_allclose(found.expressions, denoise_frames(ready.positions, [10, 70, 110], 60.0))
    assert [(out.name, "frame 9999 is not in the take" in out.why) for out in found.left_out] == [("s_9999", True)]
    with pytest.raises(BadInput, match="s_9999: frame 9999 is not in the take"):
        take_in_head(ready, [rest, far], strict=True)
    with pytest.raises(BadInput, match=r"0 scans of selected frames can be used"):
        take_in_head(ready, [far])
    assert FRAMES == (10, 70, 110)
