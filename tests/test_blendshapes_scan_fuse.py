"""Frames averaged on one map."""

import numpy as np

from mien.blendshapes.cylinder_map import CylinderLayout
from mien.blendshapes.scan.fuse import FuseConfig, fill_holes, fuse, largest_piece

LAYOUT = CylinderLayout(4.0)
PLAIN = FuseConfig(smooth_mm=0, hole_mm=0)


def frames(count: int = 9) -> np.ndarray:
    rng = np.random.default_rng(0)
    return (90 + 0.5 * rng.normal(size=(count, *LAYOUT.shape))).astype(np.float32)


def test_the_average_is_calmer_than_a_frame():
    radii = frames()
    result = fuse(radii, np.ones_like(radii), LAYOUT, PLAIN)
    inside = np.isfinite(result.radii)
    assert np.std(result.radii[inside]) < 0.4 * np.std(radii[0])
    assert abs(result.deviation_mm - 0.45) < 0.1


def test_a_frame_that_is_far_off_does_not_count():
    radii = frames()
    radii[3] += 15
    robust = fuse(radii, np.ones_like(radii), LAYOUT, PLAIN).radii
    plain = fuse(radii, np.ones_like(radii), LAYOUT, FuseConfig(robust=False, smooth_mm=0, hole_mm=0)).radii
    assert abs(np.nanmean(robust) - 90) < 0.05 < 1 < np.nanmean(plain) - 90


def test_pixels_seen_at_a_slant_count_less_and_are_less_sure():
    radii = frames(4)
    radii[2:] += 1.0
    cosines = np.ones_like(radii)
    cosines[2:] = 0.3
    result = fuse(radii, cosines, LAYOUT, PLAIN)
    assert np.nanmean(result.radii) < 90.2
    straight = fuse(radii[:2], cosines[:2], LAYOUT, PLAIN)
    slanted = fuse(radii[2:], cosines[2:], LAYOUT, PLAIN)
    assert np.median(straight.confidence) > 3 * np.median(slanted.confidence)


def test_the_filter_calms_without_rounding_a_step():
    radii = frames(2)
    half = LAYOUT.shape[1] // 2
    radii[:, :, half:] += 20
    calm = fuse(radii, np.ones_like(radii), LAYOUT, FuseConfig(smooth_mm=8, edge_mm=1.5, hole_mm=0)).radii
    assert np.std(calm[5:-5, 5 : half - 5]) < 0.6 * np.std(radii[0, 5:-5, 5 : half - 5])
    assert (calm[5:-5, half] - calm[5:-5, half - 1]).min() > 17


def test_enclosed_holes_are_filled_and_open_ones_stay():
    radii = np.full((40, 60), 90.0)
    radii[10:13, 20:23] = np.nan
    radii[:, 50:] = np.nan
    closed = fill_holes(radii, 5)
    np.testing.assert_allclose(closed[10:13, 20:23], 90, atol=1e-6)
    assert np.isnan(closed[:, 50:]).all()
    assert np.isnan(fill_holes(radii, 2)[11, 21])


def test_shoulders_are_not_the_head():
    mask = np.zeros((20, 20), bool)
    mask[2:10, 3:15] = True
    mask[14:16, 3:15] = True
    assert largest_piece(mask)[5, 5]
    assert not largest_piece(mask)[15, 5]
