from dataclasses import replace

import numpy as np
import pytest

from detail_patch import bent, patch, training, wrinkled
from mien.detail.base_mesh import BaseConfig
from mien.detail.fit import DetailConfig, HighPass, fit_detail, texel_mm
from mien.detail.polynomial import PolynomialConfig
from mien.detail.texture_space import texels

SMALL = DetailConfig(base=BaseConfig(vertices=0), medium_size=48, fine_size=96, high_pass_mm=4.0)


@pytest.fixture(scope="module")
def model():
    return fit_detail(training(), SMALL)


def test_both_maps_together_leave_little(model):
    """Furrows of 0.4 mm that grow with the square of a squeeze: what is left is a few hundredths."""
    good = ~model.fine.unreliable
    assert np.median(model.fine.error_mm[good]) < 0.02
    assert np.median(model.medium.error_mm) < 0.06


def test_detail_is_zero_at_the_neutral_but_for_what_smoothing_took(model):
    row, column = np.divmod(model.medium.texels.pixels, model.medium.texels.size)
    inner = (np.abs(row - 24) < 14) & (np.abs(column - 24) < 14)
    assert np.abs(model.medium.polynomial.coefficients[inner, -1]).max() < 0.3


def test_quadratic_detail_asks_for_quadratic_terms():
    linear = fit_detail(training(), replace(SMALL, medium=PolynomialConfig(1), fine_size=0))
    cubic = fit_detail(training(), replace(SMALL, medium=PolynomialConfig(3), fine_size=0))
    square = fit_detail(training(), replace(SMALL, fine_size=0))
    errors = [np.sqrt(np.mean(m.medium.error_mm**2)) for m in (linear, square, cubic)]
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] > 0.5 * errors[1]


def test_frames_with_holes_are_left_out_texel_by_texel():
    whole, holed = training(), training()
    clip = holed.clips[0]

    def frames():
        for i, frame in enumerate(clip.frames()):
            vertices = frame.vertices.copy()
            if i == 3:
                vertices[:200] = np.nan
            if i == 4:
                vertices[200:400] += 100.0
            yield replace(frame, vertices=vertices)

    holed = replace(holed, clips=(replace(clip, frames=frames), holed.clips[1]))
    a, b = (fit_detail(t, replace(SMALL, fine_size=0)) for t in (whole, holed))
    assert np.isfinite(b.medium.polynomial.coefficients).all()
    np.testing.assert_allclose(np.median(b.medium.error_mm), np.median(a.medium.error_mm), atol=0.01)


def test_high_pass_takes_a_ramp_out_and_keeps_a_ripple():
    grid = texels(patch(), 96)
    row, column = np.divmod(grid.pixels, 96)
    inner = (np.abs(row - 48) < 25) & (np.abs(column - 48) < 25)
    np.testing.assert_allclose(HighPass(grid, 5.0)(0.1 * column)[inner], 0, atol=1e-3)
    ripple = np.cos(2 * np.pi * column / 6)
    np.testing.assert_allclose(HighPass(grid, 5.0)(ripple)[inner], ripple[inner], atol=0.01)


def test_texels_have_their_size():
    assert texel_mm(patch(), 64) == pytest.approx(60 / 0.9 / 64 * 1.06, rel=0.05)


def test_wrinkles_are_what_the_patch_says():
    mesh = patch()
    np.testing.assert_allclose(wrinkled(mesh, 0.1, 0.0, 0.0), bent(mesh.vertices, 0.1, 0.0))
