from dataclasses import replace

import numpy as np
import pytest

from detail_patch import painted, training
from mien.detail.base_mesh import BaseConfig
from mien.detail.disk.maps import read_detail, write_detail
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.reflectance import ReflectanceConfig
from mien.detail.synthesize import Synthesizer

CONFIG = DetailConfig(
    base=BaseConfig(vertices=0), medium_size=64, fine_size=0, reflectance=ReflectanceConfig(dot_radius_mm=6.0)
)


@pytest.fixture(scope="module")
def model():
    return fit_detail(painted(training()), CONFIG)


def colours(model, frame):
    """Of a frame of the first clip, as synthesised."""
    markers = model.head.aligned(painted(training()).clips[0].markers)[frame]
    return Synthesizer(model).frame(markers).colors


def test_colour_follows_the_squeeze_and_no_dot_is_left_also_from_disk(model, tmp_path):
    write_detail(tmp_path, model)
    for learnt in (model, read_detail(tmp_path)):
        for frame, red in ((0, 0.6), (-1, 0.8)):
            found = colours(learnt, frame)
            np.testing.assert_allclose(np.median(found, axis=0), [red, 0.4, 0.3], atol=0.02)
            assert np.abs(found[:, 0] - red).mean() < 0.01
            np.testing.assert_allclose(found[:, 1], 0.4, atol=0.01)
    assert 0 < model.reflectance.polynomial.seen.mean() < 1


def test_no_deformation_draws_a_colour_that_was_not_seen(model, tmp_path):
    """Squeezed and sheared farther than any clip, without the rein on d1 and d2: skin was 0.6 to 0.8 in red."""
    write_detail(tmp_path, model)
    for learnt in (model, read_detail(tmp_path)):
        far = 40 * np.random.default_rng(0).normal(size=(len(learnt.reference), 5))
        free = replace(learnt.reflectance.polynomial, limits=None).evaluate(learnt.reflectance.field.parameters(far))
        assert np.abs(free).max() > 1
        found = learnt.reflectance.driven.values(far)
        assert (found >= [0.595, 0.395, 0.295]).all()
        assert (found <= [0.805, 0.405, 0.305]).all()


def test_dots_stay_where_they_are_not_taken_out():
    kept = fit_detail(painted(training()), replace(CONFIG, reflectance=ReflectanceConfig(dot_radius_mm=0.0)))
    assert colours(kept, 0).min() < 0.2


def test_clips_without_colours_teach_no_colour_and_stop_none_that_have(model):
    grey, whole = training(), painted(training())
    assert fit_detail(grey, CONFIG).reflectance is None
    assert fit_detail(whole, replace(CONFIG, reflectance=ReflectanceConfig(learn=False))).reflectance is None
    mixed = replace(whole, clips=(whole.clips[0], grey.clips[1]))
    np.testing.assert_allclose(np.median(colours(fit_detail(mixed, CONFIG), -1), axis=0), [0.8, 0.4, 0.3], atol=0.02)
