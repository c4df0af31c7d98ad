import numpy as np
from scipy import ndimage

from mien.light.motion import MotionConfig, at_slot, compensated, slot_flow
from mien.light.patterns import paper_set

PATTERNS = paper_set(64, 64)


def texture(shift):
    rng = np.random.default_rng(0)
    smooth = ndimage.gaussian_filter(rng.normal(size=(140, 160)), 3)
    wide = 0.5 + 0.3 * smooth / np.abs(smooth).max()
    return ndimage.shift(wide, (shift * 0.4, shift), order=3, mode="reflect")[20:120, 20:140]


def capture(pixels_a_slot):
    return np.stack([texture(pixels_a_slot * slot) for slot in range(12)])


def test_flow_a_slot_is_found_and_still_faces_are_left_alone():
    flow = slot_flow(capture(0.6), PATTERNS)
    np.testing.assert_allclose(np.median(flow[20:-20, 20:-20], axis=(0, 1)), [-0.6, -0.24], atol=0.05)
    assert not slot_flow(capture(0.0), PATTERNS).any()


def test_lamps_conditions_come_to_one_moment_and_patterns_stay():
    images = capture(0.6)
    flow = slot_flow(images, PATTERNS)
    steady = compensated(images, PATTERNS, flow, 5.5)
    truth = texture(0.6 * 5.5)[20:-20, 20:-20]
    for slot in PATTERNS.of("constant", "gradient"):
        before = np.abs(images[slot][20:-20, 20:-20] - truth).mean()
        assert np.abs(steady[slot][20:-20, 20:-20] - truth).mean() < 0.2 * before
    np.testing.assert_array_equal(steady[0], images[0])


def test_no_flow_changes_nothing():
    image = texture(0.0)
    assert at_slot(image, np.zeros((100, 120, 2)), 3.0) is image
    assert MotionConfig().compensate
