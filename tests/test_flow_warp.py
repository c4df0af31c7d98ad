"""Reading between pixels and pyramids."""

import numpy as np
import pytest

from mien._kernels import flow as kernels
from mien.flow.checkerboard import framed
from mien.flow.warp import enlarge, pyramid, shrink, smooth, spline_coefficients, warp


def _grid(h, w):
    y, x = np.mgrid[:h, :w].astype(float)
    return x, y


def _wave(x, y):
    return np.sin(0.3 * x + 0.1) * np.cos(0.25 * y) + 0.01 * x


def test_warp_reads_a_known_function():
    x, y = _grid(40, 50)
    flow = np.stack([1.3 + 0.01 * y, -0.7 + 0.02 * x], -1)
    moved = warp(_wave(x, y), flow)
    known = _wave(x + flow[..., 0], y + flow[..., 1])
    x, y = x + flow[..., 0], y + flow[..., 1]
    inner = (x > 7) & (x < 42) & (y > 7) & (y < 32)
    np.testing.assert_allclose(moved[inner], known[inner], atol=2e-4)


def test_warp_is_nan_outside_and_exact_at_pixels():
    x, y = _grid(10, 12)
    image = np.stack([_wave(x, y), x], -1)
    moved = warp(image, np.stack([np.full((10, 12), 2.0), np.zeros((10, 12))], -1))
    np.testing.assert_allclose(moved[:, :-2], image[:, 2:], atol=1e-9)
    assert np.isnan(moved[:, -2:]).all()


def test_bilinear_warp_keeps_holes_to_themselves():
    image = np.ones((9, 9))
    image[4, 4] = np.nan
    moved = warp(image, np.full((9, 9, 2), 0.5), order=1)
    assert np.isnan(moved[3:5, 3:5]).all()
    assert np.isfinite(moved[:3, :8]).all()


def test_spline_derivatives_match_differences_of_the_spline():
    """Derivatives that the kernel gives are those of the values that it gives."""
    x, y = _grid(30, 32)
    image = _wave(x, y).astype(np.float32)[..., None]
    step = 0.05

    def at(dx, dy):
        u, v = framed(np.full((30, 32), 0.3 + dx, np.float32)), framed(np.full((30, 32), 0.4 + dy, np.float32))
        flows = u[0], v[0], u[1], v[1], 0
        fixed = np.zeros((1, 6, 30, 16), np.float32), np.ones((1, 2, 30, 16), np.float32), np.float32(0), False
        fields, inside = np.empty((1, 8, 30, 16), np.float32), np.empty((30, 16), np.float32)
        kernels.linearise(spline_coefficients(image), np.ones((30, 32), np.float32), *flows, *fixed, fields, inside)
        return fields[0, :, 4:-4, 3:-3].astype(float)

    here = at(0, 0)
    for field, slope, (dx, dy) in ((0, 3, (1, 0)), (0, 4, (0, 1)), (3, 5, (1, 0)), (3, 6, (0, 1)), (4, 7, (0, 1))):
        difference = (at(step * dx, step * dy) - at(-step * dx, -step * dy))[field] / (2 * step)
        np.testing.assert_allclose(here[slope], difference, atol=2e-3)


@pytest.mark.parametrize("shape", [(20, 24), (13, 17)])
def test_resampling_keeps_constants_and_places(shape):
    """A linear ramp stays the same ramp: the images' outer borders coincide."""
    x, y = _grid(40, 48)
    ramp = np.stack([x, y, np.ones_like(x)], -1).astype(np.float32)
    small = shrink(ramp, shape)
    xs, ys = _grid(*shape)
    expected = np.stack([(xs + 0.5) * 48 / shape[1] - 0.5, (ys + 0.5) * 40 / shape[0] - 0.5, np.ones(shape)], -1)
    np.testing.assert_allclose(small[3:-3, 3:-3], expected[3:-3, 3:-3], atol=2e-4)
    np.testing.assert_allclose(small[..., 2], 1, atol=1e-6)
    back = enlarge(small, (40, 48))
    np.testing.assert_allclose(back[8:-8, 8:-8], ramp[8:-8, 8:-8], atol=5e-3)


def test_smooth_is_a_gaussian():
    image = np.zeros((31, 31, 1), np.float32)
    image[15, 15] = 1
    x, y = _grid(31, 31)
    expected = np.exp(-((x - 15) ** 2 + (y - 15) ** 2) / (2 * 1.5**2))
    np.testing.assert_allclose(smooth(image, 1.5)[..., 0], expected / expected.sum(), atol=2e-5)


def test_shrink_does_not_alias():
    x, _ = _grid(64, 64)
    stripes = np.cos(np.pi * x).astype(np.float32)[..., None]
    assert np.abs(shrink(stripes, (32, 32)))[:, 2:-2].max() < 0.02


def test_pyramid_ignores_what_is_masked():
    rng = np.random.default_rng(0)
    x, y = _grid(48, 64)
    image, weight = _wave(x, y)[..., None], np.ones((48, 64), np.float32)
    weight[10:25, 20:40] = 0
    spoiled = image.copy()
    spoiled[weight == 0] = rng.standard_normal(spoiled[weight == 0].shape) * 1e6
    spoiled[12, 22] = np.nan
    levels = [pyramid(i, i, weight, weight, presmooth=0.6) for i in (image, spoiled)]
    assert len(levels[0]) == 3
    for clean, dirty in zip(*levels, strict=True):
        np.testing.assert_array_equal(clean.source, dirty.source)
        assert np.isfinite(clean.source).all()
        assert clean.source_weight.min() < 0.5 < clean.source_weight.max()


def test_pyramid_has_even_widths_and_true_scales():
    image = np.zeros((50, 70, 2))
    levels = pyramid(image, image, np.ones((50, 70)), np.ones((50, 70)), coarsest=6)
    assert [level.source.shape[1] % 2 for level in levels] == [0] * len(levels)
    assert levels[0].source.shape == (50, 70, 2)
    for level in levels:
        np.testing.assert_allclose(level.scale, (level.source.shape[1] / 70, level.source.shape[0] / 50))
