from dataclasses import replace

import numpy as np
import pytest

from detail_patch import training
from mien.detail.training import Clip, Frame, TrainingSet, aligned_frames, aligned_markers
from mien.errors import BadInput
from mien.transforms import Transform, rotation_from_vector


def test_the_head_s_motion_goes_from_markers_and_surface_alike():
    whole = training()
    clip = whole.clips[0]
    T = Transform(rotation_from_vector(np.array([0.2, -0.4, 0.1])), np.array([10.0, 20, 30]))
    moved = Clip(clip.name, T.apply(clip.markers), lambda: (Frame(T.apply(f.vertices)) for f in clip.frames()))
    for a, b in zip(
        aligned_frames(replace(whole, clips=(clip,))), aligned_frames(replace(whole, clips=(moved,))), strict=True
    ):
        np.testing.assert_allclose(b.markers, a.markers, atol=1e-9)
        np.testing.assert_allclose(b.vertices, a.vertices, atol=1e-9)


def test_the_neutral_is_left_where_it_is():
    whole = training()
    np.testing.assert_allclose(aligned_markers(whole.markers, whole.markers[None])[0], whole.markers, atol=1e-9)


def test_clips_that_do_not_fit_are_refused():
    whole = training()
    clip = whole.clips[0]
    with pytest.raises(BadInput, match="24 markers"):
        TrainingSet(whole.mesh, whole.markers, whole.labels, (replace(clip, markers=clip.markers[:, :24]),))
    gap = clip.markers.copy()
    gap[2, 3] = np.nan
    with pytest.raises(BadInput, match="missing"):
        TrainingSet(whole.mesh, whole.markers, whole.labels, (replace(clip, markers=gap),))
    with pytest.raises(BadInput, match="no training clips"):
        TrainingSet(whole.mesh, whole.markers, whole.labels, ())
    short = replace(clip, frames=lambda: iter(list(clip.frames())[:-1]))
    with pytest.raises(BadInput, match="8 frames of markers"):
        list(aligned_frames(replace(whole, clips=(short,))))
    other = replace(clip, frames=lambda: iter([Frame(np.zeros((5, 3)))]))
    with pytest.raises(BadInput, match="one topology"):
        list(aligned_frames(replace(whole, clips=(other,))))
