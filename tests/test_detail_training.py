from dataclasses import replace

import numpy as np
import pytest

from detail_patch import training
from mien.detail.training import Clip, Frame, TrainingSet, aligned_frames, head_markers
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
    np.testing.assert_allclose(whole.head.aligned(whole.markers[None])[0], whole.markers, atol=1e-9)


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


def test_a_jaw_that_opens_does_not_move_the_forehead():
    """The lower markers drop by 20 mm; the others stay where they are but for a head that nods."""
    reference = np.random.default_rng(5).normal(0, 40, (40, 3))
    drop = np.where(reference[:, 1] < -20, 20.0, 0.0)[:, None] * [0, -1, 0]
    still = reference + np.linspace(0, 1, 9)[:, None, None] * drop
    T = Transform(rotation_from_vector(np.linspace(0, 0.3, 9)[:, None] * [1.0, 0, 0]), np.zeros((9, 3)))
    head = head_markers(reference, T.apply(still))
    assert head.steadiness[reference[:, 1] < -20].max() < 0.01
    np.testing.assert_allclose(head.aligned(T.apply(still)), still, atol=0.05)


def test_a_frame_in_which_still_markers_move_is_posed_by_the_others():
    """One brow rises in one frame of many: steadiness hardly knows it, the frame itself tells."""
    reference = np.random.default_rng(6).normal(0, 40, (40, 3))
    still = np.repeat(reference[None], 30, axis=0)
    still[17, reference[:, 1] > 30] += [0, 6.0, 0]
    head = head_markers(reference, still)
    np.testing.assert_allclose(head.pose(still[17:18]).translation, 0, atol=0.05)
    np.testing.assert_allclose(head.aligned(still)[17], still[17], atol=0.1)


def test_jaws_that_agree_with_one_another_do_not_take_over():
    """A jaw of a third of the markers turns in two of six clips, as one body, while all others stir a little."""
    rng = np.random.default_rng(7)
    reference = rng.normal(0, 40, (60, 3))
    jaw = reference[:, 1] < -20
    still = reference + 0.4 * rng.normal(size=(36, 60, 3))
    still[24:, jaw] = Transform(rotation_from_vector(np.array([0.25, 0, 0])), np.zeros(3)).apply(reference[jaw])
    head = head_markers(reference, still)
    turned = head.pose(still).rotation[:, 2, 1]
    assert np.abs(turned).max() < 0.01
