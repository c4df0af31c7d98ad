from dataclasses import replace

import numpy as np
import pytest

from detail_patch import bent, patch, training, wrinkled
from mien.detail.base_mesh import BaseConfig
from mien.detail.disk.maps import read_detail, write_detail
from mien.detail.fit import DetailConfig, HighPass, fit_detail
from mien.detail.polynomial import PolynomialConfig
from mien.detail.synthesize import SynthesisConfig, Synthesizer
from mien.detail.texture_space import texels
from mien.errors import BadInput
from mien.io.exr import read_exr

SMALL = DetailConfig(base=BaseConfig(vertices=0), medium_size=48, fine_size=96, high_pass_mm=4.0)


@pytest.fixture(scope="module")
def model():
    return fit_detail(training(), SMALL)


def test_both_maps_together_leave_little(model):
    """Furrows of 0.4 mm that grow with the square of a squeeze: what is left is a few hundredths."""
    good = ~model.fine.unreliable
    assert np.median(model.fine.error[good]) < 0.02
    assert np.median(model.medium.error) < 0.06


def test_detail_is_zero_at_the_neutral_but_for_what_smoothing_took(model):
    row, column = np.divmod(model.medium.texels.pixels, model.medium.texels.size)
    inner = (np.abs(row - 24) < 14) & (np.abs(column - 24) < 14)
    assert np.abs(model.medium.polynomial.coefficients[inner, -1]).max() < 0.3


def test_quadratic_detail_asks_for_quadratic_terms():
    linear = fit_detail(training(), replace(SMALL, medium=PolynomialConfig(1), fine_size=0))
    cubic = fit_detail(training(), replace(SMALL, medium=PolynomialConfig(3), fine_size=0))
    square = fit_detail(training(), replace(SMALL, fine_size=0))
    errors = [np.sqrt(np.mean(m.medium.error**2)) for m in (linear, square, cubic)]
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] > 0.5 * errors[1]


def test_maps_of_the_whole_deformation_follow_too_and_are_found_again_on_disk(tmp_path):
    whole = PolynomialConfig(whole_deformation=True)
    made = fit_detail(training(), replace(SMALL, medium=whole, fine=whole))
    assert np.median(made.medium.error) < 0.06
    assert made.medium.polynomial.coefficients.shape[1] == 9
    write_detail(tmp_path, made)
    vectors = made.domain.vectors(made.head.aligned(training().clips[0].markers))[-1]
    for one, two in ((made.medium, read_detail(tmp_path).medium), (made.fine, read_detail(tmp_path).fine)):
        np.testing.assert_allclose(two.driven.values(vectors), one.driven.values(vectors), atol=1e-3)


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
    np.testing.assert_allclose(np.median(b.medium.error), np.median(a.medium.error), atol=0.01)


def with_vertices(clip, change):
    """The clip with every frame's vertices changed."""
    return replace(clip, frames=lambda: (replace(f, vertices=change(f.vertices)) for f in clip.frames()))


def hidden(vertices):
    """A corner of the patch that no frame shows."""
    out = vertices.copy()
    out[:200] = np.nan
    return out


def test_texels_never_seen_are_marked_and_no_map_holds_a_nan(tmp_path):
    whole = training()
    holed = replace(whole, clips=tuple(with_vertices(clip, hidden) for clip in whole.clips))
    model = fit_detail(holed, replace(SMALL, medium_size=24, fine_size=32))
    for detail in (model.medium, model.fine):
        unseen = ~detail.polynomial.seen
        assert 0.1 < unseen.mean() < 0.3
        assert detail.unreliable[unseen].all()
        assert (detail.polynomial.coefficients[unseen] == 0).all()
        assert np.isfinite(detail.polynomial.coefficients).all()
    write_detail(tmp_path / "maps", model)
    for name in ("medium.exr", "fine.exr"):
        assert all(np.isfinite(channel).all() for channel in read_exr(tmp_path / "maps" / name).values())
    back = read_detail(tmp_path / "maps")
    np.testing.assert_array_equal(back.fine.polynomial.seen, model.fine.polynomial.seen)
    np.testing.assert_array_equal(np.isnan(back.fine.error), np.isnan(model.fine.error))
    frame = Synthesizer(back, SynthesisConfig(fine_vertices=True)).frame(model.reference * [0.9, 1, 1])
    assert np.isfinite(frame.vertices).all()
    assert np.isfinite(frame.fine).all()


def test_markers_of_another_unit_and_frames_without_skin_are_one_line():
    whole = training()
    metres = tuple(replace(clip, markers=clip.markers * 1000) for clip in whole.clips)
    with pytest.raises(BadInput, match="mm from the neutral's mesh"):
        fit_detail(replace(whole, markers=whole.markers * 1000, clips=metres), SMALL)
    away = tuple(with_vertices(clip, lambda vertices: vertices + 100.0) for clip in whole.clips)
    with pytest.raises(BadInput, match="no frame shows skin within 15 mm"):
        fit_detail(replace(whole, clips=away), replace(SMALL, medium_size=16))


def test_maps_stay_within_what_they_are_in_training(model):
    """However far the markers go; and in training nothing is held back."""
    clips = training()
    seen = [model.domain.vectors(model.head.aligned(clip.markers)) for clip in clips.clips]
    shown = np.stack([model.medium.driven.values(frame) for frame in np.concatenate(seen)])
    free = replace(model.medium.polynomial, limits=None)
    expected = [free.evaluate(model.medium.field.parameters(frame)) for frame in np.concatenate(seen)]
    np.testing.assert_allclose(shown, expected, atol=1e-4)
    rng = np.random.default_rng(0)
    for _ in range(3):
        found = model.medium.driven.values(50 * rng.normal(size=(25, 5)))
        assert (found >= shown.min(axis=0) - 1e-4).all()
        assert (found <= shown.max(axis=0) + 1e-4).all()


def test_high_pass_takes_a_ramp_out_and_keeps_a_ripple():
    grid = texels(patch(), 96)
    row, column = np.divmod(grid.pixels, 96)
    inner = (np.abs(row - 48) < 25) & (np.abs(column - 48) < 25)
    np.testing.assert_allclose(HighPass(grid, 5.0)(0.1 * column)[inner], 0, atol=1e-3)
    ripple = np.cos(2 * np.pi * column / 6)
    np.testing.assert_allclose(HighPass(grid, 5.0)(ripple)[inner], ripple[inner], atol=0.01)


def test_wrinkles_are_what_the_patch_says():
    mesh = patch()
    np.testing.assert_allclose(wrinkled(mesh, 0.1, 0.0, 0.0), bent(mesh.vertices, 0.1, 0.0))
