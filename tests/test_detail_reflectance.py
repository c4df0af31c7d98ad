from dataclasses import replace

import numpy as np
import pytest

from detail_patch import training
from mien.detail.base_mesh import BaseConfig, base_mesh
from mien.detail.domain import deformation_vectors
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.reflectance import fit_reflectance, under_dots
from mien.errors import BadInput

CONFIG = DetailConfig(base=BaseConfig(vertices=0), medium_size=64, fine_size=0)


def painted(dots: bool):
    """The patch in skin colour, redder the more it is squeezed; black round each marker where there are dots."""
    whole = training()

    def frames(clip):
        for markers, frame in zip(clip.markers, clip.frames(), strict=True):
            squeeze = 1 - np.ptp(markers[:, 0]) / np.ptp(whole.markers[:, 0])
            colors = np.tile([0.6 + squeeze, 0.4, 0.3], (len(frame.vertices), 1))
            if dots:
                colors[under_dots(frame.vertices, markers, 2.0)] = 0
            yield replace(frame, colors=colors)

    return replace(whole, clips=tuple(replace(c, frames=lambda c=c: frames(c)) for c in whole.clips))


@pytest.fixture(scope="module")
def subject():
    clips = painted(dots=True)
    model = fit_detail(clips, CONFIG)
    return clips, model, base_mesh(clips.mesh, CONFIG.base).on_training(model.medium.texels.attachment)


def test_colour_follows_the_squeeze_and_no_dot_is_left(subject):
    clips, model, on_training = subject
    learnt = fit_reflectance(clips, model, on_training, CONFIG, 6.0)
    markers = model.head.aligned(clips.clips[0].markers)
    for frame, red in ((0, 0.6), (-1, 0.8)):
        colors = learnt.driven.values(deformation_vectors(model.domain.strains, markers)[frame])
        np.testing.assert_allclose(np.median(colors, axis=0), [red, 0.4, 0.3], atol=0.02)
        np.testing.assert_allclose(colors[:, 1], 0.4, atol=0.01)


def test_dots_stay_where_they_are_not_taken_out(subject):
    clips, model, on_training = subject
    kept = fit_reflectance(clips, model, on_training, CONFIG, 0.0)
    assert kept.driven.values(np.zeros((25, 5))).min() < 0.2


def test_frames_without_colours_are_refused(subject):
    _, model, on_training = subject
    with pytest.raises(BadInput, match="without colours"):
        fit_reflectance(training(), model, on_training, CONFIG)
