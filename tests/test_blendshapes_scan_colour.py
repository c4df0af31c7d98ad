"""Frames' colours on the map."""

import numpy as np

from mien.blendshapes.scan.colour import ColourConfig, Photo, blend, level, normals_of

SHAPE = (40, 60)


def photo(tone: float, left: float, right: float) -> Photo:
    """A grey photo seen at cosines that go from `left` to `right`."""
    return Photo(np.full((*SHAPE, 3), tone), np.tile(np.linspace(left, right, SHAPE[1]), (SHAPE[0], 1)))


def test_exposure_and_white_balance_go_to_the_first():
    first = photo(0.3, 1, 1)
    other = Photo(first.colors * np.array([1.4, 1.0, 0.7]), first.facing)
    np.testing.assert_allclose(level([first, other])[1].colors, first.colors)


def test_two_exposures_blend_without_a_seam():
    photos = [photo(0.3, 1, 0.0), photo(0.5, 0.0, 1)]
    seam = blend(photos, 1.0, ColourConfig(level=False))
    levelled = blend([photo(0.3, 1, 0.55), photo(0.5, 0.55, 1)], 1.0, ColourConfig())
    assert np.abs(np.diff(seam[20, :, 0])).max() < 0.03
    assert np.ptp(levelled) < 1e-3


def test_detail_comes_from_the_view_that_sees_it_straight():
    x = np.arange(SHAPE[1])
    stripes = 0.4 + 0.2 * np.sin(x)[None, :, None] * np.ones((SHAPE[0], 1, 3))
    sharp, dull = Photo(stripes, np.full(SHAPE, 0.95)), Photo(np.full_like(stripes, 0.4), np.full(SHAPE, 0.6))
    banded = blend([sharp, dull], 1.0, ColourConfig(level=False))
    single = blend([sharp, dull], 1.0, ColourConfig(level=False, band_mm=0))
    assert np.std(banded[20, 10:-10, 0]) > 1.2 * np.std(single[20, 10:-10, 0])


def test_where_nobody_looks_there_is_no_colour():
    seen = photo(0.3, 1, 1)
    seen.facing[:, :10] = 0
    assert np.isnan(blend([seen], 1.0, ColourConfig())[:, :10]).all()


def test_normals_point_outwards():
    y, x = np.mgrid[:20.0, :20.0]
    plane = np.stack([x, -y, np.zeros_like(x)], -1).astype(np.float32)
    np.testing.assert_allclose(normals_of(plane)[5, 5], [0, 0, 1], atol=1e-6)
